# frozen_string_literal: true

# Makes a scene of hills, casts rays at it, moves it, and reads the reason of an error.
#
#   ruby -I generated first_query.rb
#
# Variables: SIGHTLINE_ENDPOINT, HOST:PORT or unix:PATH; SIGHTLINE_TOKEN; SIGHTLINE_TLS_CA, a PEM file.
require "digest"
require "securerandom"
require_relative "columns"
require_relative "connection"
require_relative "mesh"

include Sightline::V1

SCENE = "projects/default/scenes/hills-ruby"
SIDE = 257 # vertices along each side of the hills, one unit apart
CHUNK = 1 << 20 # bytes of a mesh in one message
BATCH = 8192 # rays in one message

def hills
  positions = []
  faces = []
  SIDE.times do |y|
    SIDE.times do |x|
      positions.push(x, y, (((x * x) + (3 * y * y) + (x * y)) % 64) / 8.0)
      next if x + 1 == SIDE || y + 1 == SIDE

      corner = (y * SIDE) + x
      faces.push(corner, corner + 1, corner + SIDE, corner + 1, corner + SIDE + 1, corner + SIDE)
    end
  end
  Mesh.blob(positions, faces)
end

# A mesh that the server has is not sent again.
def upload(server, blob)
  digest = Mesh.digest(blob)
  missing = server.call(server.blobs, :find_missing_blobs, FindMissingBlobsRequest.new(digests: [digest]))
  return digest if missing.digests.empty?

  chunks = (0...blob.bytesize).step(CHUNK).lazy.map do |offset|
    data = blob.byteslice(offset, CHUNK)
    UploadBlobRequest.new(digest: digest, offset: offset, data: data, finish: offset + data.bytesize == blob.bytesize)
  end
  server.blobs.upload_blob(chunks, metadata: server.metadata)
  digest
end

def cast(server, origins, directions, consistency = nil)
  rays = Columns.rays(origins.flatten, directions.flatten)
  answer = server.call(server.rays, :cast_rays, CastRaysRequest.new(scene: SCENE, rays: rays, consistency: consistency))
  puts "revision #{answer.served.revision}"
  columns = Columns.of(answer).values_at(:HIT_FIELD_T, :HIT_FIELD_NODE, :HIT_FIELD_PRIMITIVE)
  columns.transpose.each do |t, node, primitive|
    puts "  t #{t} node #{node} primitive #{primitive}"
  end
end

# Ray i of many: slanting rays over the hills and beyond.
def part(first, count)
  origins = (first...first + count).flat_map { |i| [(i % 500) * 0.53, (i / 500) * 1.31, 20] }
  Columns.rays(origins, [0.25, -0.125, -1] * count)
end

# Casts `total` rays over one call. The first message says what is asked; of later ones only the rays count. A thread of
# gRPC sends them, and waits where the server reads slowly.
def cast_many(server, total)
  requests = (0...total).step(BATCH).lazy.map do |first|
    rays = part(first, [BATCH, total - first].min)
    StreamCastRaysRequest.new(chunk: first / BATCH, request: CastRaysRequest.new(scene: SCENE, rays: rays))
  end
  bytes = Hash.new { |hash, field| hash[field] = String.new(encoding: Encoding::BINARY) }
  hits = 0
  server.rays.stream_cast_rays(requests, metadata: server.metadata(SCENE)).each do |answer|
    answer.response.columns.each { |column| bytes[column.field] << column.data }
    hits += Columns.of(answer.response)[:HIT_FIELD_T].count(&:finite?)
  end
  columns = bytes.values_at(:HIT_FIELD_T, :HIT_FIELD_NODE, :HIT_FIELD_PRIMITIVE).join
  puts "#{total} rays, #{hits} hits, columns #{Digest::SHA256.hexdigest(columns)}"
end

# Lifts a node. A call that is repeated with the same request id changes nothing.
def lift(server, node, height)
  matrices = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, height].pack("E*")
  update = Update.new(set_transforms: SetTransforms.new(nodes: [node], matrices: matrices))
  request = ApplyUpdatesRequest.new(scene: SCENE, request_id: SecureRandom.uuid, updates: [update])
  first = server.call(server.scenes, :apply_updates, request)
  again = server.call(server.scenes, :apply_updates, request)
  puts "moved at revision #{first.revision.revision}, and again: #{again.replayed ? 'replayed' : 'moved twice'}"
  first.revision.token
end

authority = ENV["SIGHTLINE_TLS_CA"]
server = Connection.new(ENV.fetch("SIGHTLINE_ENDPOINT", "127.0.0.1:50151"), token: ENV.fetch("SIGHTLINE_TOKEN", ""),
                                                                            ca: authority && File.read(authority))
digest = upload(server, hills)
puts "mesh #{digest}"
put = [PutSceneRequest.new(scene: Scene.new(name: SCENE), replace: true),
       PutSceneRequest.new(nodes: [PutNode.new(node: -1, name: "hills", mesh_digest: digest)]),
       PutSceneRequest.new(finish: true)]
scene = server.scenes.put_scene(put, metadata: server.metadata(SCENE)).scene
puts "scene of #{scene.nodes} node, #{scene.triangles_unique} triangles"

origins = [[10.3, 20.6, 30], [100.25, 200.5, 30], [-5, -5, 30], [0, 0, 30]]
directions = [[0, 0, -1], [0.1, 0.2, -1], [0, 0, -1], [0, 0, 0]] # the third misses, the last is none
cast(server, origins, directions)
cast_many(server, 100_000)
token = lift(server, 1, 2.5)
cast(server, origins, directions, Consistency.new(at_least: token))

begin
  server.call(server.rays, :cast_rays, CastRaysRequest.new(scene: "#{SCENE}-2", rays: part(0, 1)))
rescue GRPC::BadStatus => error
  raise unless Connection.details_of(error)[:reason] == "SCENE_NOT_FOUND"

  puts "as expected: #{error.details}"
end

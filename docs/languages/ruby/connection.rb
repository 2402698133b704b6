# frozen_string_literal: true

# A connection to a Sightline server: services, tokens, TLS, deadlines, retries, and the reasons of errors.
require "json"
require "google/protobuf/well_known_types"
require "grpc"
require "google/rpc/error_details_pb"
require "sightline/v1/blob_services_pb"
require "sightline/v1/query_services_pb"
require "sightline/v1/scene_services_pb"

class Connection
  DEADLINE = 60 # seconds
  ATTEMPTS = 8 # of a call that the server refuses for now
  LOCAL = /\A(unix:.*|(127\.\d+\.\d+\.\d+|localhost|\[::1\]):\d+)\z/

  # Calls that may be repeated where the server cannot be reached: they read, or have a request id.
  REPEATABLE = {
    "RayQueryService" => %w[CastRays QueryPoints],
    "SceneService" => %w[GetScene ListScenes BatchGetNodes ApplyUpdates],
    "BlobService" => %w[FindMissingBlobs GetUploadStatus]
  }.freeze
  NAMES = REPEATABLE.flat_map do |service, methods|
    methods.map { |method| { service: "sightline.v1.#{service}", method: method } }
  end
  RETRY = { maxAttempts: 4, initialBackoff: "0.1s", maxBackoff: "2s", backoffMultiplier: 2,
            retryableStatusCodes: ["UNAVAILABLE"] }.freeze
  SERVICE_CONFIG = JSON.generate(methodConfig: [{ name: NAMES, retryPolicy: RETRY }])

  attr_reader :rays, :scenes, :blobs

  # `ca`: the PEM of an authority, for TLS.
  def initialize(endpoint, token: "", ca: nil)
    raise "the token has characters other than visible ASCII" unless token.match?(/\A[!-~]*\z/)

    unless token.empty? || ca || endpoint.match?(LOCAL)
      raise "the token is not sent to #{endpoint} without encryption: name an authority"
    end

    @token = token
    credentials = ca ? GRPC::Core::ChannelCredentials.new(ca) : :this_channel_is_insecure
    options = { "grpc.service_config" => SERVICE_CONFIG, "grpc.keepalive_time_ms" => 15_000 }
    options["grpc.enable_http_proxy"] = 0 if endpoint.match?(LOCAL)
    services = [Sightline::V1::RayQueryService, Sightline::V1::SceneService, Sightline::V1::BlobService]
    @rays, @scenes, @blobs = services.map do |service|
      service::Stub.new(endpoint, credentials, channel_args: options)
    end
  end

  # `scene`: what the call is about, for balancers.
  def metadata(scene = "")
    { "authorization" => ("Bearer #{@token}" unless @token.empty?), "x-scene" => (scene unless scene.empty?) }.compact
  end

  # A call with one request, which may be repeated: what the server refuses for now is sent again when it says.
  def call(service, method, request)
    attempt = 0
    begin
      attempt += 1
      scene = request.respond_to?(:scene) ? request.scene : ""
      service.public_send(method, request, metadata: metadata(scene), deadline: Time.now + DEADLINE)
    rescue GRPC::ResourceExhausted => error
      delay = Connection.details_of(error)[:retry_delay]
      raise if delay.nil? || attempt == ATTEMPTS

      sleep(delay * (1 + rand))
      retry
    end
  end

  # What a program may depend on in an error: the reason (empty: it is not the server's), and after how many seconds the
  # call may be repeated (nil: the server does not say so).
  def self.details_of(error)
    found = { reason: "", retry_delay: nil }
    (error.to_rpc_status&.details || []).each do |detail|
      if (info = detail.unpack(Google::Rpc::ErrorInfo))
        found[:reason] = info.reason
      elsif (wait = detail.unpack(Google::Rpc::RetryInfo))
        found[:retry_delay] = wait.retry_delay.seconds + (wait.retry_delay.nanos * 1e-9)
      end
    end
    found
  end
end

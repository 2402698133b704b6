# frozen_string_literal: true

# A mesh as the server takes it: the bytes of an SLM1 blob, and the digest that names them.
require "digest"

module Mesh
  # `positions`: three numbers a vertex; `faces`: three indices of vertices a face.
  def self.blob(positions, faces)
    raise ArgumentError, "#{positions.size} coordinates are not three a vertex" unless (positions.size % 3).zero?
    raise ArgumentError, "#{faces.size} indices are not three a face" unless (faces.size % 3).zero?

    header = ["SLM1", 0, positions.size / 3, faces.size / 3].pack("a4 L< Q< Q<") # 0: copy number
    header + positions.pack("e*") + faces.pack("L<*")
  end

  def self.digest(bytes)
    "sha256:#{Digest::SHA256.hexdigest(bytes)}/#{bytes.bytesize}"
  end
end

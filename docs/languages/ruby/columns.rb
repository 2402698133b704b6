# frozen_string_literal: true

# Columns of numbers: the bytes of rays from arrays, and arrays from the bytes of an answer.
require "sightline/v1/query_pb"

module Columns
  # Little-endian: E float64, e float32, Q< uint64, L< uint32, C uint8.
  FORMATS = {
    HIT_FIELD_T: "E*", HIT_FIELD_NODE: "Q<*", HIT_FIELD_PRIMITIVE: "L<*", HIT_FIELD_BARYCENTRIC: "e*",
    HIT_FIELD_NORMAL: "e*", HIT_FIELD_HIT: "C*", HIT_FIELD_WORK: "L<*", HIT_FIELD_COUNT: "L<*", HIT_FIELD_OFFSET: "L<*",
    HIT_FIELD_HIT_BITS: "C*", HIT_FIELD_POSITION: "E*", HIT_FIELD_NAME: "L<*"
  }.freeze

  # Rays of the protocol from two arrays of numbers, three a ray.
  def self.rays(origins, directions)
    Sightline::V1::Rays.new(float64: true, origins: origins.pack("E*"), directions: directions.pack("E*"),
                            count: origins.size / 3)
  end

  # The columns of an answer by their fields.
  def self.of(response)
    response.columns.to_h do |column|
      format = FORMATS.fetch(column.field) { raise "a column of the unknown field #{column.field}" }
      [column.field, column.data.unpack(format)]
    end
  end
end

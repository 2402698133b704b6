// The members of imported scenes and animations, for an archive.
#pragma once

#include "client/importer/animation.h"
#include "client/importer/imported_scene.h"

namespace sightline::client::importer {

template <class Archive>
void fields(Archive& archive, ImportedMesh& mesh) {
  archive(mesh.name, mesh.vertices, mesh.faces, mesh.triangles, mesh.lines_and_points);
}

template <class Archive>
void fields(Archive& archive, ImportedNode& node) {
  archive(node.name, node.parent, node.parent_from_local, node.mesh);
}

template <class Archive>
void fields(Archive& archive, Warning& warning) {
  archive(warning.kind, warning.count, warning.first, warning.message, warning.is_note);
}

template <class Archive>
void fields(Archive& archive, ImportedScene& scene) {
  archive(scene.meshes, scene.nodes, scene.up_axis, scene.meters_per_unit, scene.warnings);
}

template <class Archive, class Value>
void fields(Archive& archive, Key<Value>& key) {
  archive(key.seconds, key.value);
}

template <class Archive, class Value>
void fields(Archive& archive, Tangents<Value>& tangents) {
  archive(tangents.in, tangents.out);
}

template <class Archive, class Value>
void fields(Archive& archive, Track<Value>& track) {
  archive(track.keys, track.before, track.after, track.interpolation, track.tangents);
}

template <class Archive>
void fields(Archive& archive, NodeChannel& channel) {
  archive(channel.node, channel.positions, channel.rotations, channel.scalings);
}

template <class Archive>
void fields(Archive& archive, Skin& skin) {
  archive(skin.bones, skin.first, skin.influences);
}

template <class Archive>
void fields(Archive& archive, Deformation& deformation) {
  archive(deformation.node, deformation.mesh, deformation.weights);
}

template <class Archive>
void fields(Archive& archive, Animation& animation) {
  archive(animation.name, animation.seconds, animation.channels, animation.deformations);
}

template <class Archive>
void fields(Archive& archive, Rig& rig) {
  archive(rig.parent_from_local, rig.scene_from_file, rig.offsets, rig.vertices, rig.skins,
          rig.shapes, rig.weights);
}

template <class Archive>
void fields(Archive& archive, AnimatedScene& scene) {
  archive(scene.scene, scene.rig, scene.animations);
}

}  // namespace sightline::client::importer

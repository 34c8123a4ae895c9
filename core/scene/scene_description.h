// A scene as data: what scene.proto says, translated, with every default filled in and every tree
// at hand. What check_scene looks at and a Scene is built from. Offline. SI, frame W unless named.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/contact/contact_problem.h"
#include "core/instrument/instrument_options.h"
#include "core/instrument/string_parameters.h"
#include "core/math/pose.h"
#include "core/simulation/workspace_map.h"
#include "core/tree/measured_tree.h"

namespace hapticd {

/// What is touched, and what is known of how well it represents what is drawn.
struct ShapeDescription {
  std::shared_ptr<const MeasuredTree> tree;  ///< never null in a description that is complete
  bool exact = false;                        ///< spheres written out: they are the shape
  std::string tree_name;                     ///< as the scene names it; empty when written out
  std::string mesh;                          ///< to draw, as the scene names it; may be empty
};

/// A rigid or soft part of a tool.
struct PartDescription {
  std::string name;
  ShapeDescription shape;  ///< in the part's frame P
  Pose X_GP;
  ToolPart softness;
};

struct ToolDescription {
  std::uint32_t tool_id = 0;
  std::string name;
  std::vector<PartDescription> parts;
  Pose X_WG;
  CouplingStiffness coupling;
  double coupling_damping = 0.0;  ///< N s/m
  WorkspaceMap workspace;
  double force_gain = 1.0;
};

struct BodyDescription {
  std::string name;
  ShapeDescription shape;  ///< in the body's frame B
  Pose X_WB;
  double friction_coefficient = 0.0;  ///< [0, 10]
};

/// A rigid line, bar or bent pipe.
struct LineDescription {
  std::string name;
  std::vector<Vector3> points_W;
  double radius = 0.0;
  double friction_coefficient = 0.0;  ///< [0, 10]
};

struct StringDescription {
  std::string name;
  StringParameters parameters;
  double sag = 0.0;  ///< drop at mid-span along -y of W, m
  /// Numbers of the lines and bodies that it lies on where it is pressed on them.
  std::vector<std::size_t> touched_lines;
  std::vector<std::size_t> touched_bodies;
};

struct SceneDescription {
  std::string name;
  std::vector<ToolDescription> tools;
  std::vector<BodyDescription> bodies;
  std::vector<LineDescription> lines;
  std::vector<StringDescription> strings;
  InstrumentOptions instrument;
  bool tones = false;   ///< tone events are wanted
  bool torque = false;  ///< off: forces alone are rendered
  ContactOptions contact;
  std::uint32_t quality_level = 0;  ///< that filled in what the scene leaves open of `contact`
  bool quality_automatic = false;   ///< the level is where it begins, and follows a budget
};

}  // namespace hapticd

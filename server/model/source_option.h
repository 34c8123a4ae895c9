// The mesh a command works on: a file or a model, its unit, and the checks it has to pass. Not RT.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "server/model/mesh_file.h"

namespace hapticd {

struct SourceOptions {
  std::string mesh;              ///< path, or model:NAME
  std::string unit = "m";        ///< of the file
  std::optional<double> scale;   ///< metres per unit of the file, instead
  std::vector<std::string> set;  ///< parameters of a model, name=value
  bool repair = false;
};

/// Adds --unit, --scale, --set and --repair.
void add_source_options(CLI::App& command, SourceOptions& options);

/// A mesh that a tree can be made of.
struct CheckedMesh {
  SourceMesh source;
  std::string name;  ///< of the file without folders, or model:NAME with its parameters
};

/// Reads or makes the mesh and checks it; findings go to stderr, warnings only unless `quiet`.
/// Throws std::runtime_error naming file, faults and remedies when no tree can be made,
/// std::invalid_argument for options that make no sense.
[[nodiscard]] CheckedMesh load_source(const SourceOptions& options, bool quiet);

/// The mesh of the model `name` with `set` (name=value). Throws std::invalid_argument naming what
/// there is.
[[nodiscard]] TriangleMesh make_model(const std::string& name, const std::vector<std::string>& set);

}  // namespace hapticd

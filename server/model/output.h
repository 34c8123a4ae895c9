// What build and inspect say about a tree: report, JSON, picture. Not RT.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "server/model/tree_report.h"

namespace hapticd {

/// Files to write; "-" is stdout, "" nothing.
struct OutputOptions {
  std::string report, json, picture;
  int levels = kMaxTreeDepth;
};

/// Adds --report, --json, --picture and --levels.
void add_output_options(CLI::App& command, OutputOptions& options);

/// Writes `text` to a file, or to stdout for "-".
void write_text(const std::string& path, const std::string& text);

/// Measures the leaves of `file` against `mesh` if any output needs it, completes `report` and
/// writes what is asked for. Throws std::runtime_error with the path.
void write_output(const OutputOptions& options, const TriangleMesh& mesh,
                  const MeshDistance& distance, const MeasuredTree& file, TreeReport report);

}  // namespace hapticd

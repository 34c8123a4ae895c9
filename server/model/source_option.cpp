// See source_option.h.
#include "server/model/source_option.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "proto/hints/nearest_name.h"
#include "server/model/length.h"
#include "server/model/packing/mesh_check.h"
#include "server/model/shapes/model_catalogue.h"

namespace hapticd {
namespace {

constexpr std::string_view kModelPrefix = "model:";

std::vector<ParameterValue> parse_parameters(const std::vector<std::string>& set) {
  std::vector<ParameterValue> values;
  for (const std::string& text : set) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw std::invalid_argument("--set " + text + ": write name=value, as in radius=5mm");
    }
    values.emplace_back(text.substr(0, equals), parse_length(text.substr(equals + 1)));
  }
  return values;
}

/// Throws where the model has no parameter of that name, with the one that may be meant.
void check_parameter(const NamedModel& model, const std::string& name) {
  std::vector<std::string> names;
  for (const ModelParameter& known : model.parameters()) names.emplace_back(known.range.name);
  if (std::find(names.begin(), names.end(), name) != names.end()) return;
  std::string text = "no parameter named " + name + "." + hints::did_you_mean(name, names);
  text += " There are";
  for (const std::string& known : names) text.append(" ").append(known);
  throw std::invalid_argument(text);
}

double metres_per_unit(const SourceOptions& options) {
  const double metres = options.scale.value_or(unit_in_metres(options.unit));
  if (!(metres > 0.0) || !std::isfinite(metres)) {
    throw std::invalid_argument("--scale is a number above 0, metres per unit of the file");
  }
  return metres;
}

CheckedMesh load(const SourceOptions& options) {
  CheckedMesh loaded;
  if (!options.mesh.starts_with(kModelPrefix)) {
    if (!options.set.empty()) {
      throw std::invalid_argument("--set is for a model, as in model:pillar");
    }
    loaded.source = read_mesh(options.mesh, metres_per_unit(options));
    loaded.name = std::filesystem::path(options.mesh).filename().string();
    return loaded;
  }
  loaded.source.mesh = make_model(options.mesh.substr(kModelPrefix.size()), options.set);
  loaded.source.hash = mesh_hash(loaded.source.mesh);
  loaded.name = options.mesh;
  for (const std::string& text : options.set) loaded.name += " " + text;
  return loaded;
}

void repair(TriangleMesh& mesh, const std::string& path) {
  const MeshReport before = check_mesh(mesh);
  for (const MeshFinding& finding : before.findings) {
    // Their indices cannot be followed.
    if (finding.fault <= MeshFault::kIndexOutOfRange) return;
  }
  const MeshRepair done = repair_mesh(mesh);
  if (done.dropped + done.flipped == 0) return;
  std::fprintf(stderr, "%s: repaired: %lld collapsed triangles dropped, %lld turned round\n",
               path.c_str(), static_cast<long long>(done.dropped),
               static_cast<long long>(done.flipped));
}

}  // namespace

void add_source_options(CLI::App& command, SourceOptions& options) {
  command
      .add_option("--unit", options.unit, "unit of the mesh file: um, mm, cm, m, in (default m)")
      ->check(CLI::IsMember({"um", "mm", "cm", "m", "in"}));
  command
      .add_option("--scale", options.scale, "metres per unit of the mesh file, instead of --unit")
      ->excludes("--unit");
  command
      .add_option("--set", options.set, "parameter of a model, as in radius=5mm; may be repeated")
      ->type_name("NAME=VALUE");
  command.add_flag("--repair", options.repair,
                   "drop collapsed triangles and turn those that face the wrong way");
}

CheckedMesh load_source(const SourceOptions& options, bool quiet) {
  CheckedMesh loaded = load(options);
  if (options.repair) repair(loaded.source.mesh, options.mesh);
  const MeshReport report = check_mesh(loaded.source.mesh);
  std::string errors;
  for (const MeshFinding& finding : report.findings) {
    if (finding.severity == FaultSeverity::kError) {
      errors += (errors.empty() ? "" : "\n  ") + options.mesh + ": " + describe(finding);
    } else if (!quiet) {
      const char* kind = finding.severity == FaultSeverity::kWarning ? "warning" : "note";
      std::fprintf(stderr, "%s: %s: %s\n", options.mesh.c_str(), kind, describe(finding).c_str());
    }
  }
  if (!usable(report)) throw std::runtime_error(errors);
  return loaded;
}

TriangleMesh make_model(const std::string& name, const std::vector<std::string>& set) {
  const NamedModel* model = find_model(name);
  if (model == nullptr) {
    std::string listed;
    std::vector<std::string> names;
    for (const NamedModel& known : model_catalogue()) {
      names.emplace_back(known.name);
      listed += " " + names.back();
    }
    throw std::invalid_argument("no model named '" + name + "'." +
                                hints::did_you_mean(name, names) + " There are" + listed);
  }
  const std::vector<ParameterValue> values = parse_parameters(set);
  for (const ParameterValue& value : values) check_parameter(*model, value.first);
  return model->make(values);
}

}  // namespace hapticd

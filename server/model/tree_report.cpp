// See tree_report.h.
#include "server/model/tree_report.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdarg>
#include <cstdio>

#include "server/model/length.h"
#include "server/model/printed_json.h"

namespace hapticd {
namespace {

/// Points that time_exhaustive looks at: a second for 10^5 triangles.
constexpr std::size_t kTimedPoints = 500;

// NOLINTNEXTLINE(cert-dcl50-cpp): printf is the shortest way to a table
[[gnu::format(printf, 1, 2)]] std::string print(const char* format, ...) {
  std::array<char, 512> text{};
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  return text.data();
}

std::string row(const std::string& what, const std::string& value) {
  return "| " + what + " | " + value + " |\n";
}

/// Length, and as a share of the diagonal.
std::string with_share(double length, double diagonal) {
  return format_length(length) + print(" (%.3g %%)", 100.0 * length / diagonal);
}

std::string statistics(const DistanceStatistics& d, double diagonal) {
  return "max " + with_share(d.max, diagonal) + ", mean " + with_share(d.mean, diagonal) +
         ", p99 " + with_share(d.p99, diagonal);
}

Json json_of(const DistanceStatistics& d) {
  return {{"max", d.max}, {"mean", d.mean}, {"p99", d.p99}};
}

}  // namespace

std::vector<Sphere> level_spheres(const SphereTree& tree, int level) {
  std::vector<Sphere> spheres;
  std::vector<int> level_of(tree.nodes.size(), 1);
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    const SphereTreeNode& node = tree.nodes[n];
    if (level_of[n] > level) break;
    for (std::size_t k = 0; k < kTreeWidth; ++k) {
      if ((node.used >> k & 1U) == 0) continue;
      const bool inner = (node.inner >> k & 1U) != 0;
      if (inner) level_of[static_cast<std::size_t>(node.child[k])] = level_of[n] + 1;
      if (inner && level_of[n] < level) continue;
      spheres.push_back({{node.x[k], node.y[k], node.z[k]}, node.r[k]});
    }
  }
  return spheres;
}

double outer_bound(const MeshDistance& distance, std::span<const Sphere> spheres) {
  double outer = 0.0;
  for (const Sphere& sphere : spheres) {
    outer = std::max(outer, distance.signed_distance(sphere.p) + sphere.r);
  }
  return outer;
}

std::vector<TreeLevel> measure_levels(const TriangleMesh& mesh, const MeshDistance& distance,
                                      const SphereTree& tree, double leaf_outer,
                                      const ReportOptions& options) {
  std::vector<TreeLevel> levels;
  for (int level = 1; level <= tree.depth; ++level) {
    const std::vector<Sphere> spheres = level_spheres(tree, level);
    TreeLevel entry;
    entry.spheres = static_cast<std::int32_t>(spheres.size());
    entry.outer = level == tree.depth ? leaf_outer : outer_bound(distance, spheres);
    entry.mean = report_packing(mesh, distance, spheres, options).outside.mean;
    levels.push_back(entry);
  }
  return levels;
}

double time_exhaustive(const TriangleMesh& mesh, const MeshDistance& distance,
                       std::int64_t samples) {
  using Clock = std::chrono::steady_clock;
  const std::size_t stride = std::max<std::size_t>(1, mesh.vertices.size() / kTimedPoints);
  const auto start = Clock::now();
  double sum = 0.0;
  std::int64_t points = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += stride, ++points) {
    // Off the surface, and used: the compiler would drop a sum that is not read.
    sum += distance.nearest_by_exhaustion(1.01 * mesh.vertices[i]).distance;
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return sum < 0.0 ? 0.0 : seconds / static_cast<double>(points) * static_cast<double>(samples);
}

std::size_t memory_of(const SphereTree& tree) {
  return tree.nodes.size() * sizeof(SphereTreeNode) + tree.leaf_r.size() * 4 * sizeof(double);
}

std::string to_markdown(const TreeReport& report) {
  const MeasuredTree& file = *report.file;
  const double diagonal = report.packing.diagonal;
  std::string text = "# " + report.name + "\n\n| | |\n|---|---|\n";
  text += row("source",
              file.source_name + (report.triangles > 0 ? print(" (%zu triangles)", report.triangles)
                                                       : std::string()));
  text += row("spheres", print("%zu", file.tree.leaf_r.size()));
  text += row("bound outside", format_length(file.outer));
  text += row("bound inside", format_length(file.inner));
  if (report.has_packing) {
    text += row("diagonal", format_length(diagonal));
    text += row("outside, measured", statistics(report.packing.outside, diagonal));
    text += row("inside, measured", statistics(report.packing.inside, diagonal));
    text += row("uncovered surface", print("%.4g %%", 100.0 * report.packing.uncovered));
    text += row("scallop", format_length(report.packing.scallop));
    text += row("samples", print("%lld of the mesh, %lld of the spheres",
                                 static_cast<long long>(report.packing.mesh_samples),
                                 static_cast<long long>(report.packing.sphere_samples)));
  }
  if (report.seconds >= 0.0) {
    text += row("built in", print("%.1f s on %d thread%s", report.seconds, report.threads,
                                  report.threads == 1 ? "" : "s"));
  }
  if (report.seconds >= 0.0 && report.exhaustive_seconds > 0.0) {
    text += row("build over exhaustive evaluation",
                print("%.2f", report.seconds / report.exhaustive_seconds));
  }
  text += row("memory", print("%.1f kB", 1e-3 * static_cast<double>(memory_of(file.tree))));
  text += row("file", print("%.1f kB", 1e-3 * static_cast<double>(report.bytes)));

  text += "\n| level | spheres | bound outside | mean outside |\n|---:|---:|---:|---:|\n";
  for (std::size_t k = 0; k < file.levels.size(); ++k) {
    if (static_cast<int>(k) >= report.levels) break;
    const TreeLevel& level = file.levels[k];
    text +=
        print("| %zu%s | %d | %s | %s |\n", k + 1, k + 1 == file.levels.size() ? " (leaves)" : "",
              level.spheres, format_length(level.outer).c_str(), format_length(level.mean).c_str());
  }
  return text;
}

std::string to_json(const TreeReport& report) {
  const MeasuredTree& file = *report.file;
  Json json = {{"name", report.name},
               {"source", file.source_name},
               {"spheres", file.tree.leaf_r.size()},
               {"triangles", report.triangles},
               {"outer", file.outer},
               {"inner", file.inner}};
  if (report.has_packing) {
    json["diagonal"] = report.packing.diagonal;
    json["outside"] = json_of(report.packing.outside);
    json["inside_gap"] = json_of(report.packing.inside);
    json["uncovered"] = report.packing.uncovered;
    json["scallop"] = report.packing.scallop;
  }
  if (report.seconds >= 0.0) {
    json["seconds"] = report.seconds;
    json["threads"] = report.threads;
    json["exhaustive_seconds"] = report.exhaustive_seconds;
  }
  json["memory_bytes"] = memory_of(file.tree);
  json["file_bytes"] = report.bytes;
  Json& levels = json["levels"] = Json::array();
  for (const TreeLevel& level : file.levels) {
    levels.push_back({{"spheres", level.spheres}, {"outer", level.outer}, {"mean", level.mean}});
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace hapticd

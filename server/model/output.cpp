// See output.h.
#include "server/model/output.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <thread>

#include "server/model/mesh_file.h"
#include "server/model/picture.h"

namespace hapticd {

void add_output_options(CLI::App& command, OutputOptions& options) {
  command.add_option("--report", options.report, "Markdown file for the report, - for stdout");
  command.add_option("--json", options.json,
                     "file for the report as one line of JSON, - for stdout");
  command.add_option("--picture", options.picture, "PNG file: the mesh beside the spheres");
  command
      .add_option("--levels", options.levels,
                  "levels in the report's table, from the coarsest (default all); the tree has "
                  "them all")
      ->check(CLI::Range(1, kMaxTreeDepth));
}

void write_text(const std::string& path, const std::string& text) {
  if (path == "-") {
    std::fputs(text.c_str(), stdout);
    return;
  }
  write_bytes(path, {text.begin(), text.end()});
}

void write_output(const OutputOptions& options, const TriangleMesh& mesh,
                  const MeshDistance& distance, const MeasuredTree& file, TreeReport report) {
  report.file = &file;
  report.triangles = mesh.triangles.size();
  report.levels = options.levels;
  const std::vector<Sphere> leaves = level_spheres(file.tree, file.tree.depth);
  if (!options.report.empty() || !options.json.empty()) {
    ReportOptions measuring;
    measuring.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    const SphereTreeView view = file.tree.view();
    if (view.blend.width > 0.0) measuring.blend = &view;
    report.packing = report_packing(mesh, distance, leaves, measuring);
    report.has_packing = true;
    report.exhaustive_seconds = time_exhaustive(mesh, distance, report.packing.sphere_samples);
  }
  if (!options.report.empty()) write_text(options.report, to_markdown(report));
  if (!options.json.empty()) write_text(options.json, to_json(report));
  if (!options.picture.empty()) {
    PictureOptions drawing;
    drawing.bound = file.outer;
    write_bytes(options.picture, encode_png(draw_packing(mesh, distance, leaves, drawing)));
  }
}

}  // namespace hapticd

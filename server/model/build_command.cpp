// hapticd-model build: a sphere-tree from a mesh or a model, with its report and picture.
#include <chrono>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <thread>

#include "server/model/commands.h"
#include "server/model/length.h"
#include "server/model/output.h"
#include "server/model/packing/blend_fitting.h"
#include "server/model/packing/sphere_packing.h"
#include "server/model/progress_bar.h"
#include "server/model/source_option.h"

namespace hapticd {
namespace {

/// Bound of the leaves when neither --error nor --leaves is given.
constexpr const char* kDefaultError = "250um";
/// Samples of each surface behind the means of the level table.
constexpr std::int64_t kLevelSamples = 50'000;

struct BuildOptions {
  SourceOptions source;
  OutputOptions output;
  std::string tree;
  std::string error = kDefaultError;
  std::string inner = "0um";
  std::string blend = "0um";
  std::string mesh_out;
  int leaves = 0;
  std::uint64_t seed = 1;
  int threads = 0;
  bool quiet = false;
};

PackingOptions packing_options(const BuildOptions& options) {
  PackingOptions packing;
  packing.outer = parse_length(options.error);
  packing.inner = parse_length(options.inner);
  if (!(packing.outer > 0.0)) throw std::invalid_argument("--error must be above 0");
  if (!(packing.inner >= 0.0)) throw std::invalid_argument("--inner must not be below 0");
  if (options.leaves > 0) packing.leaves = options.leaves;
  packing.seed = options.seed;
  packing.threads = options.threads > 0
                        ? options.threads
                        : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  return packing;
}

/// Width of the blend, m; 0: none.
double blend_width(const BuildOptions& options) {
  const double width = parse_length(options.blend);
  if (width == 0.0 || (width >= kMinBlend && width <= kMaxFileLength)) return width;
  throw std::invalid_argument("--blend must be 0 or from 1um to 1000 m");
}

void build(const BuildOptions& options) {
  PackingOptions packing_choice = packing_options(options);
  const double blend = blend_width(options);
  const CheckedMesh checked = load_source(options.source, options.quiet);
  const TriangleMesh& mesh = checked.source.mesh;
  if (!options.mesh_out.empty()) write_mesh(options.mesh_out, mesh);

  const auto start = std::chrono::steady_clock::now();
  const MeshDistance distance(mesh);
  Packing packing;
  {
    ProgressBar bar("packing " + checked.name, options.quiet);
    packing_choice.progress = [&bar](double done) { bar.update(done); };
    packing = pack_spheres(mesh, distance, packing_choice);
  }
  BlendFit fit;
  if (blend > 0.0) {
    fit = fit_blend(mesh, distance, {blend, packing.outer, packing_choice.threads}, packing.leaves);
    packing.outer = fit.outer;
    packing.inner = fit.inner;
  }
  MeasuredTree file;
  file.tree = build_sphere_tree(packing.leaves);
  blend_surface(blend, file.tree);
  file.source = checked.source.hash;
  file.source_name = checked.name.substr(0, kMaxSourceName);
  file.outer = packing.outer;
  file.inner = packing.inner;
  ReportOptions measuring;
  measuring.samples = kLevelSamples;
  measuring.threads = packing_choice.threads;
  file.levels = measure_levels(mesh, distance, file.tree, file.outer, measuring);
  if (blend > 0.0) file.levels.back().mean = fit.mean;
  const std::vector<std::uint8_t> bytes = encode_sphere_tree(file);
  write_bytes(options.tree, bytes);

  TreeReport report;
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  report.threads = packing_choice.threads;
  report.name = options.tree;
  report.bytes = bytes.size();
  write_output(options.output, mesh, distance, file, report);
}

}  // namespace

void add_build_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("build", "make a sphere-tree from a mesh or a model");
  const auto options = std::make_shared<BuildOptions>();
  command
      ->add_option("MESH", options->source.mesh,
                   "mesh file (.obj .stl .ply .gltf .glb) or model:NAME")
      ->required();
  command->add_option("-o,--output", options->tree, "tree file to write")->required();
  CLI::Option* leaves =
      command->add_option("--leaves", options->leaves, "at most this many leaf spheres")
          ->check(CLI::Range(1, 1 << 24));
  command
      ->add_option("--error", options->error,
                   "no sphere further outside than this, as in 50um or 0.1mm (default 250um)")
      ->excludes(leaves);
  command->add_option("--inner", options->inner,
                      "the surface may stick out of the spheres by this (default 0: covered)");
  command->add_option("--blend", options->blend,
                      "width over which spheres blend into one smooth surface, as in 1mm: their "
                      "radii are fitted to the mesh (default 0: none)");
  add_source_options(*command, options->source);
  command->add_option("--seed", options->seed, "of the random choices (default 1)");
  command
      ->add_option("--threads", options->threads,
                   "default: one per processor; the result does not depend on it")
      ->check(CLI::Range(1, 256));
  command->add_option("--mesh-out", options->mesh_out,
                      "also write the mesh in metres (.ply or .obj)");
  add_output_options(*command, options->output);
  command->add_flag("--quiet", options->quiet, "no progress, no warnings");
  command->callback([options] { build(*options); });
}

}  // namespace hapticd

// hapticd-model inspect: what a tree file holds, and with a mesh, how far it errs from it.
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "server/model/commands.h"
#include "server/model/output.h"
#include "server/model/source_option.h"

namespace hapticd {
namespace {

/// Largest tree file that is read, bytes. 2 GiB is more than the largest tree takes.
constexpr std::uint64_t kMaxTreeFile = std::uint64_t{2} << 30U;

struct InspectOptions {
  std::string tree;
  SourceOptions source;
  OutputOptions output;
};

MeasuredTree read_tree(const std::string& path, std::size_t& size) {
  const std::vector<std::uint8_t> bytes = read_bytes(path, kMaxTreeFile);
  size = bytes.size();
  try {
    return decode_sphere_tree(bytes);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what() + ". Build it again");
  }
}

void inspect(InspectOptions options) {
  TreeReport report;
  report.name = options.tree;
  const MeasuredTree file = read_tree(options.tree, report.bytes);
  report.file = &file;
  if (options.output.report.empty() && options.output.json.empty()) options.output.report = "-";
  if (options.source.mesh.empty()) {
    if (!options.output.picture.empty()) {
      throw std::invalid_argument("--picture shows the mesh too: give it with --mesh");
    }
    report.levels = options.output.levels;
    if (!options.output.report.empty()) write_text(options.output.report, to_markdown(report));
    if (!options.output.json.empty()) write_text(options.output.json, to_json(report));
    return;
  }
  const CheckedMesh checked = load_source(options.source, false);
  if (checked.source.hash != file.source) {
    std::fprintf(stderr, "%s: warning: not the mesh that %s was made from (%s)\n",
                 options.source.mesh.c_str(), options.tree.c_str(), file.source_name.c_str());
  }
  const MeshDistance distance(checked.source.mesh);
  write_output(options.output, checked.source.mesh, distance, file, report);
}

}  // namespace

void add_inspect_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("inspect", "say what a tree file holds");
  const auto options = std::make_shared<InspectOptions>();
  command->add_option("TREE", options->tree, "tree file")->required();
  command->add_option("--mesh", options->source.mesh,
                      "measure the tree against this mesh (file or model:NAME)");
  add_source_options(*command, options->source);
  add_output_options(*command, options->output);
  command->callback([options] { inspect(*options); });
}

}  // namespace hapticd

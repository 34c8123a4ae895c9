// hapticd-oracle path: the committed path of a recording, judged by exhaustive search. Not RT.
#include <algorithm>
#include <memory>
#include <optional>

#include "tests/oracle/commands.h"
#include "tests/oracle/path_check.h"
#include "tests/oracle/scene_option.h"
#include "tests/oracle/table.h"

namespace hapticd {
namespace {

struct PathOptions {
  PathCheck check;
  std::string data;
  std::string output;
};

void write_path(PathOptions options) {
  options.check.paths = scene_paths(options.data);
  std::optional<Table> table;
  const auto begin = [&](const SceneObjects& objects) {
    std::vector<std::string> columns{"tick", "path_gap_m", "gap_m"};
    const std::vector<std::string> gaps = gap_columns(objects);
    columns.insert(columns.end(), gaps.begin(), gaps.end());
    table.emplace(columns);
  };
  check_path(options.check, begin, [&](const JudgedTick& tick) {
    double smallest = kFarthestGap;
    for (const double gap : tick.gap_of_object) smallest = std::min(smallest, gap);
    *table << tick.tick << tick.path_gap << smallest;
    for (const double gap : tick.gap_of_object) *table << gap;
    table->end_row();
  });
  write_output(options.output, table->text());
}

}  // namespace

void add_path_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "path",
      "what a recorded tool met on its way, by exhaustive search: gaps per tick as CSV, at most "
      "1 mm; fails where the recording cannot be computed again bit for bit");
  const auto options = std::make_shared<PathOptions>();
  command->add_option("RECORDING", options->check.recording, "file that hapticd --record wrote")
      ->required();
  command
      ->add_option("--scene-id", options->check.scene_id,
                   "number of the load whose ticks are judged (default: the first that has any)")
      ->type_name("ID");
  add_data_option(*command, options->data);
  add_output_option(*command, options->output);
  command->callback([options] { write_path(*options); });
}

}  // namespace hapticd

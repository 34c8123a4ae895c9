// hapticd-oracle ticks: a seeded gesture played and nothing else, for profilers. Not RT.
#include <memory>
#include <string>
#include <vector>

#include "proto/hints/quantity_option.h"
#include "tests/oracle/commands.h"
#include "tests/oracle/json.h"
#include "tests/oracle/scene_option.h"
#include "tests/oracle/study_run.h"
#include "tests/oracle/table.h"

namespace hapticd {
namespace {

struct TicksOptions {
  SceneOption scene;
  std::uint64_t seed = 1;
  double speed = 0.2;
  std::vector<std::string> settings;
  std::string output;
};

void play_ticks(const TicksOptions& options) {
  const std::unique_ptr<LoadedScene> loaded = load_scene(options.scene);
  const Scene& scene = *loaded->scene;
  const std::size_t tool = chosen_tool(options.scene, scene.description());
  PathRun judge(scene, tool);
  const StudyGesture gesture =
      choose_study_gesture(scene, tool, judge.judge(), options.seed, options.speed);
  std::string text;
  for (const std::string& each : options.settings) {
    const StudySetting setting = parse_setting(each, scene.description());
    const std::vector<StudyTick> run = play_study(scene, tool, setting, gesture, nullptr);
    text += text_of({{"name", setting.name}, {"ticks", run.size()}}) + "\n";
  }
  write_output(options.output, text);
}

}  // namespace

void add_ticks_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "ticks",
      "the ticks of measure without truth and judgement, to be run under a profiler: one call of "
      "hapticd::play_study for each setting, hapticd::Simulation::step for each tick of it");
  const auto options = std::make_shared<TicksOptions>();
  add_scene_options(*command, options->scene, true);
  command->add_option("--seed", options->seed, "of the gesture (1)")->type_name("NUMBER");
  hints::takes_unit(
      command->add_option("--speed", options->speed, "peak speed along the surface, m/s (0.2)")
          ->check(CLI::Range(1e-3, 100.0).description(""))
          ->type_name("M/S"),
      "m/s");
  command->add_option("--setting", options->settings, "as of measure; may be repeated")
      ->type_name("NAME:KEY=VALUE,...")
      ->required();
  add_output_option(*command, options->output);
  command->callback([options] { play_ticks(*options); });
}

}  // namespace hapticd

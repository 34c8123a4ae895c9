// hapticd-model check and explain: whether scenes can be played, and what playing them means.
#include <cstdio>
#include <memory>

#include "server/model/commands.h"
#include "server/model/explanation.h"
#include "server/model/scene_option.h"

namespace hapticd {
namespace {

/// Objects that a tool is led to when the cost of a tick is measured: 8 s at the worst.
constexpr int kObjectsVisited = 40;

void check(const SceneOptions& options) {
  for_each_scene(options, [](const std::string& name, const LoadedScene& loaded) {
    const Scene& scene = *loaded.scene;
    std::printf("%s: good: %zu tool(s), %zu bodies, %zu lines, %zu strings\n", name.c_str(),
                scene.description().tools.size(), scene.description().bodies.size(),
                scene.description().lines.size(), scene.description().strings.size());
  });
}

void explain_each(const SceneOptions& options) {
  bool first = true;
  for_each_scene(options, [&first](const std::string&, const LoadedScene& loaded) {
    const v1::Quality& quality = loaded.message.quality();
    const double budget_us =
        quality.has_automatic() ? quality.automatic().budget_us() : kUsualBudget_us;
    const TickCost cost = measure_ticks(*loaded.scene, 0, kObjectsVisited, budget_us);
    std::printf("%s%s", first ? "" : "\n", explain(loaded, cost).c_str());
    first = false;
  });
}

}  // namespace

void add_check_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("check", "say whether scenes can be played");
  const auto options = std::make_shared<SceneOptions>();
  add_scene_options(*command, *options);
  command->callback([options] { check(*options); });
}

void add_explain_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "explain", "say what scenes model and what they do not, its error, and what a tick costs");
  const auto options = std::make_shared<SceneOptions>();
  add_scene_options(*command, *options);
  add_quality_option(*command, *options);
  command->callback([options] { explain_each(*options); });
}

}  // namespace hapticd

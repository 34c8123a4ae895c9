// hapticd-model check and explain: whether scenes can be played, and what playing them means.
#include <cstdio>
#include <memory>
#include <string>

#include "server/model/commands.h"
#include "server/model/explanation.h"
#include "server/model/scene_json.h"
#include "server/model/scene_option.h"

namespace hapticd {
namespace {

/// Objects that a tool is led to when the cost of a tick is measured: 8 s at the worst.
constexpr int kObjectsVisited = 40;

std::string counted(std::size_t count, const char* one, const char* several) {
  return std::to_string(count) + " " + (count == 1 ? one : several);
}

void check_scene(const std::string& name, const LoadResult& result) {
  print_problems(result.problems);
  if (result.loaded == nullptr) return;
  const SceneDescription& scene = result.loaded->scene->description();
  std::printf("%s: good: %s, %s, %s, %s\n", name.c_str(),
              counted(scene.tools.size(), "tool", "tools").c_str(),
              counted(scene.bodies.size(), "body", "bodies").c_str(),
              counted(scene.lines.size(), "line", "lines").c_str(),
              counted(scene.strings.size(), "string", "strings").c_str());
}

void check(const SceneOptions& options) {
  Json scenes = Json::array();
  const bool good =
      load_each_scene(options, [&](const std::string& name, const LoadResult& result) {
        if (options.json) {
          scenes.push_back(checked_json(name, result));
        } else {
          check_scene(name, result);
        }
      });
  if (options.json) print_json({{"scenes", scenes}});
  end_with(good);
}

TickCost cost_of(const LoadedScene& loaded) {
  const v1::Quality& quality = loaded.message.quality();
  const double budget_us =
      quality.has_automatic() ? quality.automatic().budget_us() : kUsualBudget_us;
  return measure_ticks(*loaded.scene, 0, kObjectsVisited, budget_us);
}

void explain_each(const SceneOptions& options) {
  bool first = true;
  Json scenes = Json::array();
  const bool good =
      load_each_scene(options, [&](const std::string& name, const LoadResult& result) {
        print_problems(result.problems);
        if (result.loaded == nullptr) return;
        const TickCost cost = cost_of(*result.loaded);
        if (options.json) {
          scenes.push_back(explained_json(name, *result.loaded, cost));
        } else {
          std::printf("%s%s", first ? "" : "\n", explain(*result.loaded, cost).c_str());
        }
        first = false;
      });
  if (options.json) print_json({{"scenes", scenes}});
  end_with(good);
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

// hapticd-oracle descent: the hierarchical descent against a string, for a page of the report. Not
// RT.
#include <algorithm>
#include <memory>
#include <set>
#include <stdexcept>

#include "core/collision/query.h"
#include "proto/hints/quantity_option.h"
#include "tests/oracle/commands.h"
#include "tests/oracle/descent.h"
#include "tests/oracle/json.h"
#include "tests/oracle/scene_objects.h"
#include "tests/oracle/scene_option.h"
#include "tests/oracle/table.h"

namespace hapticd {
namespace {

struct DescentOptions {
  SceneOption scene;
  std::string object;
  double depth = 5e-4;
  double margin = 0.0;
  std::string output;
};

/// The middle piece of the string or line of that name; of the first where there is no name.
std::size_t chosen_capsule(const Scene& scene, const std::string& name) {
  const SceneObjects objects = scene_objects(scene);
  std::vector<std::size_t> pieces;
  for (std::size_t k = 0; k < objects.of_capsule.size(); ++k) {
    const std::string& owner = objects.names[objects.of_capsule[k]];
    if (owner == (name.empty() ? objects.names[objects.of_capsule[0]] : name)) pieces.push_back(k);
  }
  if (pieces.empty()) {
    throw std::invalid_argument("--object: the scene " + scene.description().name +
                                " has no string or line of that name. Leave it out for the first");
  }
  return pieces[pieces.size() / 2];
}

/// The leaves kept must be the contacts that the loop's own query finds.
void compare(const Descent& descent, const ContactSet& found) {
  std::set<TreeSphereId> kept;
  for (const auto& level : descent) {
    for (const DescentSphere& sphere : level) {
      if (sphere.leaf && sphere.kept) kept.insert(sphere.id);
    }
  }
  std::set<TreeSphereId> contacts;
  for (const Contact& contact : found.contacts) contacts.insert(contact.key.tool_sphere);
  if (kept != contacts) {
    throw std::runtime_error("the descent keeps " + std::to_string(kept.size()) +
                             " leaves, the loop's query " + std::to_string(contacts.size()) +
                             ". This is a fault of hapticd: report it");
  }
}

Json level_json(const std::vector<DescentSphere>& level) {
  Json spheres = Json::array();
  std::size_t kept = 0;
  for (const DescentSphere& sphere : level) {
    kept += sphere.kept ? 1 : 0;
    spheres.push_back({{"p_w_m", json_of(sphere.sphere_W.p)},
                       {"r_m", sphere.sphere_W.r},
                       {"leaf", sphere.leaf},
                       {"kept", sphere.kept}});
  }
  return {{"tested", level.size()}, {"kept", kept}, {"spheres", spheres}};
}

void write_descent(const DescentOptions& options) {
  const std::unique_ptr<LoadedScene> loaded = load_scene(options.scene);
  const Scene& scene = *loaded->scene;
  const std::size_t tool = chosen_tool(options.scene, scene.description());
  const ToolScene view = scene.tool_scene(tool);
  if (view.obstacles.capsules_W.empty()) {
    throw std::invalid_argument("--scene: it has neither string nor line. Name another scene");
  }
  const std::size_t index = chosen_capsule(scene, options.object);
  const Capsule& capsule = view.obstacles.capsules_W[index];
  Pose X_WG = scene.description().tools[tool].X_WG;
  X_WG.p += way_into(view.tool, X_WG, capsule, options.depth);
  const Descent descent = descend(view.tool, X_WG, capsule, options.margin);
  const auto found = std::make_unique<ContactSet>();
  QueryOptions query;
  query.margin = std::max(options.margin, 1e-12);
  find_contacts({view.tool, X_WG}, {{&capsule, 1}, {}}, query, *found);
  compare(descent, *found);
  Json levels = Json::array();
  for (const auto& level : descent) levels.push_back(level_json(level));
  const SceneObjects objects = scene_objects(scene);
  const Quaternion& q = X_WG.q;
  write_output(options.output,
               text_of({{"scene", scene.description().name},
                        {"object", objects.names[objects.of_capsule[index]]},
                        {"p_wa_m", json_of(capsule.p_A)},
                        {"p_wb_m", json_of(capsule.p_B)},
                        {"radius_m", capsule.r},
                        {"depth_m", options.depth},
                        {"margin_m", options.margin},
                        {"p_wg_m", json_of(X_WG.p)},
                        {"q_wg", Json::array({q.w(), q.x(), q.y(), q.z()})},
                        {"leaves", view.tool.leaf_r.size()},
                        {"tests_of_the_loop", static_cast<std::size_t>(found->tests)},
                        {"levels", levels}}) +
                   "\n");
}

}  // namespace

void add_descent_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "descent",
      "spheres of the tool's tree looked at and kept, level by level, against a string, "
      "as JSON");
  const auto options = std::make_shared<DescentOptions>();
  add_scene_options(*command, options->scene, true);
  command->add_option("--object", options->object, "string or line (default: the first)")
      ->type_name("NAME");
  hints::takes_unit(
      command->add_option("--depth", options->depth, "how deep the tool is put into it, m (0.0005)")
          ->check(CLI::Range(0.0, 1.0).description(""))
          ->type_name("M"),
      "m");
  hints::takes_unit(
      command->add_option("--margin", options->margin, "what is nearer than this is kept, m (0)")
          ->check(CLI::Range(0.0, 1.0).description(""))
          ->type_name("M"),
      "m");
  add_output_option(*command, options->output);
  command->callback([options] { write_descent(*options); });
}

}  // namespace hapticd

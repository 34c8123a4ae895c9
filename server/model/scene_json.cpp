// See scene_json.h.
#include "server/model/scene_json.h"

#include <utility>

#include "core/scene/quality.h"
#include "core/scene/sagging_cable.h"
#include "server/model/scene_features.h"
#include "server/model/string_cost.h"
#include "server/model/surface_ripple.h"
#include "server/scene_io/scene_defaults.h"

namespace hapticd {
namespace {

constexpr double kMetreInUm = 1e6;

Json json_of(const SceneProblem& problem) {
  return {{"file", problem.file},    {"line", problem.line},       {"column", problem.column},
          {"field", problem.field},  {"message", problem.message}, {"remedy", problem.remedy},
          {"warning", problem.doubt}};
}

Json json_of(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

/// Lines without the breaks that make them short on a terminal.
Json json_of(const std::vector<std::string>& lines) {
  const std::string line_break = "\n    ";
  Json list = Json::array();
  for (std::string line : lines) {
    for (std::size_t at = line.find(line_break); at != std::string::npos;
         at = line.find(line_break, at)) {
      line.replace(at, line_break.size(), " ");
    }
    list.push_back(std::move(line));
  }
  return list;
}

Json shape_json(const std::string& name, const ShapeDescription& shape, int level) {
  const PlayedShape played = played_shape(shape, level);
  Json json = {{"name", name}, {"spheres", played.spheres}, {"exact", shape.exact}};
  if (shape.exact) return json;
  json["tree"] = shape.tree_name;
  json["level"] = played.level;
  json["outside_um"] = kMetreInUm * played.outer;
  json["inside_um"] = kMetreInUm * shape.tree->inner;
  json["blend_um"] = level == 0 ? kMetreInUm * shape.tree->tree.blend.width : 0.0;
  return json;
}

Json tool_json(const Scene& scene, std::size_t index) {
  const SceneDescription& d = scene.description();
  const ToolDescription& tool = d.tools[index];
  Json parts = Json::array();
  for (const PartDescription& part : tool.parts) {
    Json json = shape_json(part.name, part.shape, shown_level(d.contact.tool_level));
    json["soft"] = part.softness.stiffness > 0.0;
    parts.push_back(std::move(json));
  }
  Json json = {{"tool_id", tool.tool_id},
               {"name", tool.name},
               {"spheres", scene.tool_spheres(index)},
               {"parts", std::move(parts)}};
  if (tool.coupling.per_axis) {
    json["coupling_w_n_per_m"] = json_of(tool.coupling.along_W());
    json["coupling_g_n_m_per_rad"] = json_of(tool.coupling.about_G());
  }
  return json;
}

Json body_json(const BodyDescription& body, int body_level) {
  Json json = shape_json(body.name, body.shape, shown_level(body_level));
  if (body_level != kLeafLevel) return json;
  const SurfaceRipple ripple = measure_ripple(body.shape.tree->tree);
  if (ripple.patches == 0) return json;
  json["ripple_rms_um"] = kMetreInUm * ripple.height;
  json["ripple_rms_degrees"] = kRadianInDegrees * ripple.angle;
  return json;
}

Json string_json(const StringDescription& string) {
  const bool sags = string.sag != 0.0;
  return {{"name", string.name},
          {"tuning", string_tuning(string.parameters)},
          {"pieces", sags ? cable_pieces(string.sag) : 1},
          {"off_parabola_um", sags ? kMetreInUm * cable_error(string.sag) : 0.0}};
}

Json accuracy_json(const LoadedScene& loaded) {
  const ContactOptions& o = loaded.scene->description().contact;
  const int level = quality_level(loaded.message.quality());
  const Quality measured = quality_of(level);
  Json json = {{"skin_um", kMetreInUm * o.skin},
               {"linearisations", o.sub_steps},
               {"stop_um", kMetreInUm * o.stop_tolerance}};
  if (!is_as_measured(o, measured)) return json;
  json["quality"] = level;
  json["force_error_percent"] = 100.0 * measured.force_error;
  json["work_to_default"] = measured.work;
  return json;
}

Json json_of(const TickTimes& times) {
  return {{"ticks", times.ticks},
          {"median_us", times.median},
          {"p99_us", times.p99},
          {"worst_us", times.worst}};
}

Json cost_json(const TickCost& cost) {
  return {{"free", json_of(cost.free)},          {"contact", json_of(cost.contact)},
          {"budget_us", cost.bounded.budget_us}, {"most_us", cost.bounded.most_us},
          {"ticks", cost.bounded.ticks},         {"cut_short", cost.bounded.beyond}};
}

Json string_costs_json(const SceneDescription& scene) {
  Json list = Json::array();
  for (const auto& [rung, count] : rungs_of(scene)) {
    const StringCost cost = string_cost(rung);
    Json json = {{"rung", rung_name(rung)},
                 {"strings", count},
                 {"silent_instructions", cost.silent},
                 {"pressed_instructions", cost.pressed}};
    if (cost.ringing >= 0.0) json["ringing_instructions"] = cost.ringing;
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace

Json checked_json(const std::string& name, const LoadResult& result) {
  Json problems = Json::array();
  for (const SceneProblem& problem : result.problems) problems.push_back(json_of(problem));
  Json json = {
      {"scene", name}, {"good", result.loaded != nullptr}, {"problems", std::move(problems)}};
  if (result.loaded == nullptr) return json;
  const SceneDescription& scene = result.loaded->scene->description();
  json["tools"] = scene.tools.size();
  json["bodies"] = scene.bodies.size();
  json["lines"] = scene.lines.size();
  json["strings"] = scene.strings.size();
  return json;
}

Json explained_json(const std::string& name, const LoadedScene& loaded, const TickCost& cost) {
  const Scene& scene = *loaded.scene;
  const SceneDescription& d = scene.description();
  Json tools = Json::array();
  for (std::size_t i = 0; i < d.tools.size(); ++i) tools.push_back(tool_json(scene, i));
  Json bodies = Json::array();
  for (const BodyDescription& body : d.bodies) {
    bodies.push_back(body_json(body, d.contact.body_level));
  }
  Json strings = Json::array();
  for (const StringDescription& string : d.strings) strings.push_back(string_json(string));
  return {{"scene", name},
          {"description", loaded.message.description()},
          {"tools", std::move(tools)},
          {"body_spheres", scene.body_spheres()},
          {"bodies", std::move(bodies)},
          {"lines", d.lines.size()},
          {"line_capsules", scene.capsule_owners().size() - scene.string_pieces()},
          {"strings", std::move(strings)},
          {"modelled", json_of(modelled(d))},
          {"not_modelled", json_of(not_modelled(d))},
          {"accuracy", accuracy_json(loaded)},
          {"tick", cost_json(cost)},
          {"string_costs", string_costs_json(d)},
          {"memory_bytes", scene.memory()}};
}

}  // namespace hapticd

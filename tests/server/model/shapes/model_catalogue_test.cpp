// The catalogue: every model is a sound solid, and every parameter in its table acts.
#include "server/model/shapes/model_catalogue.h"

#include <doctest/doctest.h>

#include <set>
#include <string>

#include "server/model/packing/mesh_check.h"
#include "tests/server/model/shapes/mesh_measures.h"

namespace hapticd::test {
namespace {

std::string complaint(std::string_view model, const std::vector<ParameterValue>& values) {
  try {
    static_cast<void>(find_model(model)->make(values));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

bool same(const TriangleMesh& a, const TriangleMesh& b) {
  return a.triangles == b.triangles && a.vertices == b.vertices;
}

/// Parameters of instrument and hand are shared by several models, not all of which use each.
std::string family(std::string_view model) {
  if (model.substr(0, 6) == "guqin_") return "guqin";
  return std::string(model.find('_') == std::string_view::npos ? model : "hand");
}

bool acts(const NamedModel& model, const ModelParameter& parameter, const TriangleMesh& defaults) {
  const bool choice = parameter.range.unit == "1";
  // A little less, or else where that does not go with the rest or is too small a change.
  for (const double share : {0.98, 1.02, 0.5, 1.5}) {
    const double value = choice ? parameter.range.high : share * parameter.value;
    const std::vector<ParameterValue> values{{std::string(parameter.range.name), value}};
    try {
      if (!same(model.make(values), defaults)) return true;
    } catch (const std::invalid_argument&) {
      continue;
    }
  }
  return false;
}

}  // namespace

TEST_CASE("every model in the catalogue is closed, faces outwards and has no crossings") {
  for (const NamedModel& model : model_catalogue()) {
    CAPTURE(std::string(model.name));
    const TriangleMesh mesh = model.make({});
    const MeshMeasures measures = measure(mesh);
    CHECK(measures.closed);
    CHECK(measures.pieces == model.solids);
    CHECK(measures.euler == 2 * model.solids);
    CHECK(measures.volume > 0.0L);
    CHECK(measures.flattest > 1e-3L);
    const MeshReport report = check_mesh(mesh);
    CHECK(usable(report));
    for (const MeshFinding& finding : report.findings) {
      CHECK(finding.fault == MeshFault::kPieces);
      CHECK(model.solids > 1);
    }
  }
}

TEST_CASE("models are found by their unique names") {
  std::set<std::string_view> names;
  for (const NamedModel& model : model_catalogue()) {
    CHECK(names.insert(model.name).second);
    CHECK(find_model(model.name) == &model);
    CHECK(!model.description.empty());
  }
  CHECK(find_model("") == nullptr);
  CHECK(find_model("guqin") == nullptr);
  for (const char* name : {"guqin_body", "hand", "index_tip", "little_nail", "pillar", "bracket"}) {
    CHECK(find_model(name) != nullptr);
  }
}

TEST_CASE("setting the defaults changes nothing, and every default is in its range") {
  for (const NamedModel& model : model_catalogue()) {
    std::vector<ParameterValue> defaults;
    for (const ModelParameter& parameter : model.parameters()) {
      CHECK(parameter.value >= parameter.range.low);
      CHECK(parameter.value <= parameter.range.high);
      CHECK(!parameter.range.meaning.empty());
      defaults.emplace_back(parameter.range.name, parameter.value);
    }
    CHECK(same(model.make(defaults), model.make({})));
  }
}

TEST_CASE("every parameter changes one of the models that list it") {
  std::set<std::string> acting;
  std::set<std::string> listed;
  // The hand itself takes longest and comes before its parts.
  const auto models = model_catalogue();
  for (auto model = models.rbegin(); model != models.rend(); ++model) {
    const TriangleMesh defaults = model->make({});
    for (const ModelParameter& parameter : model->parameters()) {
      const std::string name = family(model->name) + ' ' + std::string(parameter.range.name);
      listed.insert(name);
      if (acting.count(name) == 0 && acts(*model, parameter, defaults)) acting.insert(name);
    }
  }
  // Positions and radii of strings are not part of any mesh.
  for (const char* name : {"guqin string_radius", "guqin rest_gap"}) {
    CHECK(listed.erase(name) == 1);
  }
  CHECK(acting == listed);
}

TEST_CASE("of two values of one name the later one holds") {
  const NamedModel* const pillar = find_model("pillar");
  const std::vector<ParameterValue> twice{{"height", 0.5}, {"height", 0.2}};
  CHECK(measure(pillar->make(twice)).high.y() == 0.2);
}

TEST_CASE("an unknown name is refused with the names there are, a bad value with its range") {
  CHECK(complaint("bar", {{"lenght", 1.0}}) ==
        "no parameter named lenght; there are length radius deviation");
  CHECK(complaint("guqin_body", {{"length", 12.2}}) ==
        "guqin: length is 12.2, must be from 0.6 to 2 m");
  CHECK(complaint("little_nail", {{"nail_reach", -1.0}}) ==
        "hand: nail_reach is -1, must be from 0 to 0.01 m");
}

}  // namespace hapticd::test

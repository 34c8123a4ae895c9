// Live parameters: listed, read and changed by path, all or none.
#include "server/scene_io/scene_assignment.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "server/scene_io/scene_loader.h"
#include "server/scene_io/scene_parameters.h"
#include "tests/server/scene_io/full_scene.h"

namespace hapticd::test {
namespace {

const char* const kScene = R"(
name: "two"
tools { name: "finger" parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } }
strings { name: "A" p_wa_m: [0, 0, 0] p_wb_m: [1, 0, 0] tension_n: 20 frequency_hz: 100 }
strings { name: "B" p_wa_m: [0, 0, 0.1] p_wb_m: [1, 0, 0.1] tension_n: 40 frequency_hz: 150 }
vibration {}
tones {}
)";

/// As parameters are set in: all filled in but what quality decides.
v1::Scene filled() {
  const LoadResult result = load_scene_text(kScene, {});
  REQUIRE(result.loaded != nullptr);
  v1::Scene scene = result.loaded->message;
  leave_open(result.loaded->given, scene);
  return scene;
}

v1::SetParameter set_of(std::initializer_list<std::pair<const char*, double>> values) {
  v1::SetParameter set;
  for (const auto& value : values) {
    v1::Assignment& assignment = *set.add_assignments();
    assignment.set_path(value.first);
    assignment.set_number(value.second);
  }
  return set;
}

AssignmentResult assigned(const v1::SetParameter& set) {
  return assign_parameters(filled(), set, 1000.0);
}

}  // namespace

TEST_CASE("live parameters are listed once per kind, with unit and range") {
  const auto parameters = live_parameters(filled());
  const auto tension = std::find_if(parameters.begin(), parameters.end(), [](const auto& p) {
    return p.path() == "strings[*].tension_n";
  });
  REQUIRE(tension != parameters.end());
  CHECK(tension->unit() == "N");
  CHECK(tension->minimum() == 0.0);
  CHECK(tension->maximum() == 1e6);
  for (const auto& parameter : parameters) {
    const auto same = [&](const auto& p) { return p.path() == parameter.path(); };
    CHECK(std::count_if(parameters.begin(), parameters.end(), same) == 1);
    CHECK(parameter.path().find("radius") == std::string::npos);
  }
}

TEST_CASE("values are read by path, [*] stands for every index, and an unknown path is named") {
  const auto one = parameter_values(filled(), {"strings[1].tension_n"});
  REQUIRE(one.values.size() == 1);
  CHECK(one.values[0].number() == 40.0);
  const auto both = parameter_values(filled(), {"strings[*].tension_n"});
  REQUIRE(both.values.size() == 2);
  CHECK(both.values[0].path() == "strings[0].tension_n");
  CHECK(parameter_values(filled(), {"strings[2].tension_n"}).unknown == "strings[2].tension_n");
  CHECK(parameter_values(filled(), {""}).unknown == "");
  CHECK(parameter_values(filled(), {"quality"}).values[0].number() == 3.0);
}

TEST_CASE("an assignment reaches scene and settings") {
  const auto result = assigned(set_of({{"strings[1].tension_n", 55.0},
                                       {"tools[0].coupling.kt_n_per_m", 700.0},
                                       {"tools[0].force_gain", 0.25}}));
  REQUIRE(result.code == v1::RESULT_CODE_OK);
  CHECK(result.scene.strings(1).tension_n() == 55.0);
  CHECK(result.settings.pieces[0].tension == 20.0);
  CHECK(result.settings.pieces[1].tension == 55.0);
  CHECK(result.settings.tools[0].coupling.kt == 700.0);
  CHECK(result.settings.tools[0].force_gain == 0.25);
  CHECK(result.scene.tools(0).parts_size() == 1);
}

TEST_CASE("each axis of a coupling is live where the scene has it, and the other way is refused") {
  const char* const axes = R"(
name: "axes"
tools { name: "pen" parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  coupling { kt_w_n_per_m: [100, 200, 400] kr_g_n_m_per_rad: [0.1, 0.2, 0.5] } }
)";
  const LoadResult loaded = load_scene_text(axes, {});
  REQUIRE(loaded.loaded != nullptr);
  const v1::Scene& scene = loaded.loaded->message;
  CHECK_FALSE(scene.tools(0).coupling().has_kt_n_per_m());
  CHECK_FALSE(scene.tools(0).coupling().has_length_m());
  const auto set = [&](const char* path, double value) {
    return assign_parameters(scene, set_of({{path, value}}), 1000.0);
  };
  const AssignmentResult result = set("tools[0].coupling.kt_w_n_per_m[1]", 4000.0);
  REQUIRE(result.code == v1::RESULT_CODE_OK);
  const CouplingStiffness& coupling = result.settings.tools[0].coupling;
  CHECK((coupling.along_W() - Vector3(100, 4000, 400)).norm() < 1e-9);
  CHECK((coupling.about_G() - Vector3(0.1, 0.2, 0.5)).norm() < 1e-12);
  CHECK(set("tools[0].coupling.kr_g_n_m_per_rad[2]", 2.0).code == v1::RESULT_CODE_OK);
  CHECK(set("tools[0].coupling.kt_w_n_per_m[3]", 1.0).code == v1::RESULT_CODE_NOT_FOUND);
  CHECK(set("tools[0].coupling.kt_w_n_per_m", 1.0).code == v1::RESULT_CODE_NOT_FOUND);
  CHECK(set("tools[0].coupling.kt_w_n_per_m[0]", 0.0).code == v1::RESULT_CODE_OUT_OF_RANGE);
  const AssignmentResult far = set("tools[0].coupling.kt_w_n_per_m[0]", 0.3);
  CHECK(far.code == v1::RESULT_CODE_INVALID);
  CHECK(far.path == "tools[0].coupling.kt_w_n_per_m");
  CHECK(far.message.find("more than 1000") != std::string::npos);
  CHECK(set("tools[0].coupling.kt_n_per_m", 500.0).code == v1::RESULT_CODE_INVALID);
  CHECK(set("tools[0].coupling.kt_w_m[1]", 5.0).message.find("kt_w_n_per_m[1]") !=
        std::string::npos);
  const auto values = parameter_values(scene, {"tools[*].coupling.kt_w_n_per_m[*]"});
  REQUIRE(values.values.size() == 3);
  CHECK(values.values[2].path() == "tools[0].coupling.kt_w_n_per_m[2]");
  CHECK(values.values[2].number() == 400.0);
}

TEST_CASE("margin and skin may move as long as the margin stays above the skin") {
  CHECK(assigned(set_of({{"solver.margin_m", 2e-4}})).code == v1::RESULT_CODE_OK);
  CHECK(assigned(set_of({{"solver.skin_m", 5e-4}, {"solver.margin_m", 6e-4}})).code ==
        v1::RESULT_CODE_OK);
  for (const double margin : {2e-5, 1e-5}) {
    const AssignmentResult low = assigned(set_of({{"solver.margin_m", margin}}));
    CHECK(low.code == v1::RESULT_CODE_INVALID);
    CHECK(low.path == "solver.margin_m");
    CHECK(low.message.find("not above skin_m, 2e-05") != std::string::npos);
  }
}

TEST_CASE("a number may be given as a text with its unit, and another unit is refused") {
  const auto set_text = [](const char* path, const char* text) {
    v1::SetParameter set;
    set.add_assignments()->set_path(path);
    set.mutable_assignments(0)->set_text(text);
    return assigned(set);
  };
  CHECK(set_text("strings[1].tension_n", "55N").scene.strings(1).tension_n() == 55.0);
  CHECK(set_text("strings[1].youngs_modulus_pa", "190 GPa").scene.strings(1).youngs_modulus_pa() ==
        190e9);
  CHECK(set_text("tools[0].coupling.kt_n_per_m", "0.7N/mm").settings.tools[0].coupling.kt == 700.0);
  const AssignmentResult comma = set_text("strings[1].tension_n", "45,5");
  CHECK(comma.code == v1::RESULT_CODE_INVALID);
  CHECK(comma.message == "Write 45.5, with a point.");
  CHECK(set_text("strings[1].tension_n", "45m").message == "Give it in N.");
  CHECK(set_text("strings[1].tension_n", "-1N").code == v1::RESULT_CODE_OUT_OF_RANGE);
}

TEST_CASE("the scene's friction takes the strings along that have it, and no others") {
  LoadResult loaded = load_scene_text(full_scene_text(), {});
  REQUIRE(loaded.loaded != nullptr);
  v1::Scene scene = loaded.loaded->message;
  REQUIRE(scene.friction().coefficient() == 0.3);
  REQUIRE(scene.strings_size() > 1);
  scene.mutable_strings(0)->set_friction_coefficient(0.3);
  scene.mutable_strings(1)->set_friction_coefficient(0.2);
  const AssignmentResult result =
      assign_parameters(scene, set_of({{"friction.coefficient", 0.7}}), 1000.0);
  REQUIRE(result.code == v1::RESULT_CODE_OK);
  CHECK(result.scene.strings(0).friction_coefficient() == 0.7);
  CHECK(result.scene.strings(1).friction_coefficient() == 0.2);
  CHECK(result.settings.pieces.at(0).friction_coefficient == 0.7);
}

TEST_CASE("who mistypes a path is told which one may be meant") {
  const auto told = [](const char* path) { return assigned(set_of({{path, 1.0}})).message; };
  const std::string none = "No live parameter has this path; hapticctl get lists them.";
  CHECK(told("strings[1].tension") == none + " Did you mean strings[1].tension_n?");
  CHECK(told("tool[0].coupling.kt_n_per_m") ==
        none + " Did you mean tools[0].coupling.kt_n_per_m?");
  CHECK(told("strings.tension_n") == none + " Did you mean strings[0].tension_n?");
  CHECK(told("strings.1.tension_n") == none + " Did you mean strings[1].tension_n?");
  CHECK(told("strings.1.tensoin_n") == none + " Did you mean strings[1].tension_n?");
  CHECK(told("strings.9.tension_n") == none + " Did you mean strings[0].tension_n?");
  CHECK(told("tension") == none + " Did you mean strings[0].tension_n?");
  CHECK(told("qualty") == none + " Did you mean quality?");
  for (const char* index : {"2", "-1", "", "x", "0:1", "1.5", "99999999999"}) {
    CAPTURE(index);
    CHECK(told(("strings[" + std::string(index) + "].tension_n").c_str())
              .starts_with("The index of strings is a whole number, 0 to 1."));
  }
  CHECK(told("tools[1].coupling.kt_n_per_m") == "The index of tools is a whole number: 0.");
  CHECK(told("nonsense") == none);
  CHECK(told("[") == none);
  CHECK(told("strings[1[2].tension_n").starts_with(none));
  CHECK(told("strings[*].tension_n") == "Give an index in place of *.");
  CHECK(told("strings[99].tensoin_n") == none + " Did you mean strings[0].tension_n?");
  CHECK(told("strings[\x1b].tensoin_n") == none + " Did you mean strings[0].tension_n?");
}

TEST_CASE("one bad assignment refuses all, and its path is told") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const struct {
    const char* path;
    double value;
    v1::ResultCode code;
  } bad[] = {
      {"strings[1].tension_n", -1.0, v1::RESULT_CODE_OUT_OF_RANGE},
      {"strings[1].tension_n", nan, v1::RESULT_CODE_OUT_OF_RANGE},
      {"strings[2].tension_n", 1.0, v1::RESULT_CODE_NOT_FOUND},
      {"strings[-1].tension_n", 1.0, v1::RESULT_CODE_NOT_FOUND},
      {"strings[99999999999].tension_n", 1.0, v1::RESULT_CODE_NOT_FOUND},
      {"strings[1]x.tension_n", 1.0, v1::RESULT_CODE_NOT_FOUND},
      {"strings.tension_n", 1.0, v1::RESULT_CODE_NOT_FOUND},
      {"strings[1].radius_m", 0.001, v1::RESULT_CODE_INVALID},
      {"friction.coefficient", 0.5, v1::RESULT_CODE_NOT_FOUND},
      {"name", 1.0, v1::RESULT_CODE_INVALID},
      {"", 1.0, v1::RESULT_CODE_NOT_FOUND},
      {"quality", 5.0, v1::RESULT_CODE_OUT_OF_RANGE},
      {"quality", 1.5, v1::RESULT_CODE_OUT_OF_RANGE},
  };
  for (const auto& one : bad) {
    const auto result = assigned(set_of({{"strings[0].tension_n", 25.0}, {one.path, one.value}}));
    CAPTURE(one.path);
    CAPTURE(one.value);
    CHECK(result.code == one.code);
    CHECK(result.path == one.path);
    CHECK_FALSE(result.message.empty());
  }
}

TEST_CASE("a pose is 7 numbers, a choice one of its names") {
  v1::SetParameter set;
  v1::Assignment& pose = *set.add_assignments();
  pose.set_path("tools[0].workspace.pose_wd");
  for (const double number : {1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0}) {
    pose.mutable_numbers()->add_values(number);
  }
  v1::Assignment& level = *set.add_assignments();
  level.set_path("tones.level");
  level.set_text("TONE_LEVEL_FORCE");
  const auto result = assigned(set);
  REQUIRE(result.code == v1::RESULT_CODE_OK);
  CHECK(result.settings.tools[0].X_WD.p == Vector3(1.0, 2.0, 3.0));
  CHECK(result.settings.tools[0].instrument.tones.level == ToneLevel::kForce);
  level.set_text("TONE_LEVEL_SMELL");
  CHECK(assigned(set).code == v1::RESULT_CODE_INVALID);
  level.set_text("TONE_LEVEL_UNSPECIFIED");
  CHECK(assigned(set).code == v1::RESULT_CODE_INVALID);
  for (const double number : {0.0, -0.0, -1.0, 99.0, 0.5}) {
    level.set_number(number);
    CHECK(assigned(set).code == v1::RESULT_CODE_INVALID);
  }
  level.set_number(2.0);
  CHECK(assigned(set).code == v1::RESULT_CODE_OK);
  level.set_text("TONE_LEVEL_FORCE");
  pose.mutable_numbers()->mutable_values()->RemoveLast();
  CHECK(assigned(set).code == v1::RESULT_CODE_INVALID);
}

TEST_CASE("a level of quality sets what the scene left open of the solver") {
  const auto result = assigned(set_of({{"quality", 0.0}}));
  REQUIRE(result.code == v1::RESULT_CODE_OK);
  CHECK(result.settings.tools[0].contact.sub_steps < 24);
  CHECK(result.settings.tools[0].quality_level == 0);
  // 32 is what the level in force would have chosen.
  for (const unsigned given : {77U, 32U}) {
    v1::Scene own = filled();
    own.mutable_solver()->set_max_substeps(given);
    const auto kept = assign_parameters(own, set_of({{"quality", 0.0}}), 1000.0);
    CHECK(kept.settings.tools[0].contact.sub_steps == static_cast<int>(given));
    LiveSettings live = kept.settings.tools[0];
    take_to_level(4, own.solver(), live);
    CHECK(live.contact.sub_steps == static_cast<int>(given));
    CHECK(live.quality_level == 4);
  }
}

TEST_CASE("quality follows a budget when told auto, and stops when given a level") {
  v1::SetParameter set;
  v1::Assignment& quality = *set.add_assignments();
  quality.set_path("quality");
  quality.set_text("auto");
  auto result = assign_parameters(filled(), set, 1000.0, 250.0);
  REQUIRE(result.code == v1::RESULT_CODE_OK);
  CHECK(result.settings.tools[0].quality_automatic);
  CHECK(result.settings.tools[0].quality_level == 3);
  CHECK(parameter_values(result.scene, {"quality"}).values[0].text() == "auto");
  const char* const budget = "quality.automatic.budget_us";
  CHECK(parameter_values(result.scene, {budget}).values[0].number() == 250.0);
  result = assign_parameters(result.scene, set_of({{budget, 125.0}}), 1000.0);
  REQUIRE(result.code == v1::RESULT_CODE_OK);
  CHECK(result.scene.quality().automatic().budget_us() == 125.0);
  CHECK(result.settings.tools[0].quality_automatic);
  // auto again keeps the budget that was set.
  result = assign_parameters(result.scene, set, 1000.0, 250.0);
  CHECK(result.scene.quality().automatic().budget_us() == 125.0);
  CHECK(assign_parameters(result.scene, set_of({{budget, 0.0}}), 1000.0).code ==
        v1::RESULT_CODE_OUT_OF_RANGE);
  result = assign_parameters(result.scene, set_of({{"quality", 1.0}}), 1000.0);
  REQUIRE(result.code == v1::RESULT_CODE_OK);
  CHECK_FALSE(result.settings.tools[0].quality_automatic);
  CHECK(result.settings.tools[0].quality_level == 1);
  CHECK(assign_parameters(result.scene, set_of({{budget, 1.0}}), 1000.0).code ==
        v1::RESULT_CODE_NOT_FOUND);
  quality.set_text("best");
  CHECK(assigned(set).code == v1::RESULT_CODE_INVALID);
}

}  // namespace hapticd::test

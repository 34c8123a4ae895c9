// What a scene says of its strings arrives: axial stiffness, losses, waves and what tunes them.
// Truth: the comments of scene.proto, and f = sqrt(T / mu) / (2 L).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "server/scene_io/scene_assignment.h"
#include "server/scene_io/scene_loader.h"
#include "tests/server/scene_io/full_scene.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// A scene of one string of 0.8 m with `words`, which rings.
std::string with_string(const std::string& words, const std::string& features = "wave {}") {
  return "name: \"one\" tools { name: \"t\" parts { name: \"p\" shape { spheres { centre_m: [0, 1, "
         "0] radius_m: 0.005 } } } }\n"
         "strings { name: \"s\" p_wa_m: [0, 0, 0] p_wb_m: [0.48, 0, 0.64] " +
         words + " }\nvibration {}\n" + features + "\n";
}

LoadResult loaded(const std::string& text) {
  LoadResult result = load_inline(text);
  REQUIRE_MESSAGE(result.loaded != nullptr, list(result.problems));
  return result;
}

StringParameters parameters_of(const std::string& words) {
  return loaded(with_string(words)).loaded->scene->description().strings.at(0).parameters;
}

/// The doubts of `result` about `field`.
std::vector<SceneProblem> doubts(const LoadResult& result, const std::string& field) {
  std::vector<SceneProblem> found;
  for (const SceneProblem& problem : result.problems) {
    if (problem.doubt && problem.field == field) found.push_back(problem);
  }
  return found;
}

/// What is played once `path` is set to `value`, in the scene of a string with `words`.
AssignmentResult assigned(const std::string& words, const char* path, double value) {
  const LoadResult result = loaded(with_string(words));
  v1::SetParameter set;
  set.add_assignments()->set_path(path);
  set.mutable_assignments(0)->set_number(value);
  return assign_parameters(result.loaded->message, set, 1000.0);
}

double pitch(double tension, double density) { return std::sqrt(tension / density) / 1.6; }

}  // namespace

TEST_CASE("an axial stiffness that is given is the string's, 0 too, and it may change in flight") {
  for (const char* const words : {"axial_stiffness_n: 0", "axial_stiffness_n: 13400"}) {
    const double given = std::stod(std::string(words).substr(19));
    CHECK(derive_string(parameters_of(words)).axial_stiffness == given);
  }
  CHECK(derive_string(parameters_of("radius_m: 0.001")).axial_stiffness ==
        within(1.9e5 * 3.14159265358979, 1e-12));
  const AssignmentResult result =
      assigned("axial_stiffness_n: 5000", "strings[0].axial_stiffness_n", 6000.0);
  REQUIRE(result.code == v1::RESULT_CODE_OK);
  CHECK(derive_string(result.settings.pieces.at(0)).axial_stiffness == 6000.0);
}

TEST_CASE("Young's modulus beside an axial stiffness is said to do nothing, and alone is not") {
  const std::string modulus = "youngs_modulus_pa: 1e9 ";
  const LoadResult both = loaded(with_string(modulus + "axial_stiffness_n: 5000 frequency_hz: 90"));
  REQUIRE(doubts(both, "strings[0].youngs_modulus_pa").size() == 1);
  CHECK(to_text(both.problems.at(0)).find("axial_stiffness_n wins") != std::string::npos);
  const LoadResult alone = loaded(with_string(modulus + "frequency_hz: 90"));
  CHECK(doubts(alone, "strings[0].youngs_modulus_pa").empty());
}

TEST_CASE("the loss of high modes arrives, and is said to do nothing where there are none") {
  CHECK(parameters_of("loss_n2_per_s: 0.03 frequency_hz: 90").loss_n2 == 0.03);
  CHECK(parameters_of("frequency_hz: 90").loss_n2 == 0.002);
  const std::string words = "loss_n2_per_s: 0.03 frequency_hz: 90";
  CHECK(doubts(loaded(with_string(words)), "strings[0].loss_n2_per_s").empty());
  CHECK(doubts(loaded(with_string(words, "preset: PRESET_PAPER")), "strings[0].loss_n2_per_s")
            .size() == 1);
}

TEST_CASE("wave gives strings its modes, 32 where it says nothing, and lets them climb to it") {
  for (const auto& [words, modes] : {std::pair{"wave {}", 32}, std::pair{"wave { modes: 4 }", 4},
                                     std::pair{"wave { modes: 64 }", 64}}) {
    const LoadResult result = loaded(with_string("frequency_hz: 90", words));
    CHECK(result.problems.empty());
    const SceneDescription& scene = result.loaded->scene->description();
    CHECK(scene.instrument.modes == modes);
    CHECK(scene.strings.at(0).parameters.max_level == StringDetail::kModes);
    CHECK(result.loaded->message.strings(0).max_level() == v1::STRING_LEVEL_WAVE);
  }
  const LoadResult few = load_inline(with_string("frequency_hz: 90", "wave { modes: 3 }"));
  CHECK(find_fault(few.problems, "wave.modes") != nullptr);
}

TEST_CASE("wave says how often strings are stepped, 32 times a millisecond where it says nothing") {
  for (const auto& [words, substeps] :
       {std::pair{"", 32}, std::pair{"wave {}", 32}, std::pair{"wave { modes: 16 }", 32},
        std::pair{"modes { count: 16 }", 32}, std::pair{"wave { substeps: 8 }", 8},
        std::pair{"wave { modes: 64 substeps: 64 }", 64}}) {
    const std::string wave = words;
    CAPTURE(wave);
    const LoadResult result = loaded(with_string("frequency_hz: 90", wave));
    CHECK(result.loaded->scene->description().instrument.substeps == substeps);
    if (result.loaded->message.has_wave()) {
      CHECK(result.loaded->message.wave().substeps() == static_cast<unsigned>(substeps));
    }
  }
}

TEST_CASE("sub-steps other than 8, 16, 32 and 64 are refused where they are written") {
  for (const int substeps : {9, 24, 63}) {
    const LoadResult result = load_inline(
        with_string("frequency_hz: 90", "wave { substeps: " + std::to_string(substeps) + " }"));
    CHECK(result.loaded == nullptr);
    const SceneProblem* const fault = find_fault(result.problems, "wave.substeps");
    REQUIRE(fault != nullptr);
    CHECK(fault->line == 4);
    CHECK(fault->message == std::to_string(substeps) + " is not in 8, 16, 32 or 64");
    CHECK(!fault->remedy.empty());
  }
}

TEST_CASE("the rung of waves is written WAVE, and read by its former name too") {
  CHECK(v1::StringLevel_Name(v1::STRING_LEVEL_WAVE) == "STRING_LEVEL_WAVE");
  for (const char* const name : {"STRING_LEVEL_WAVE", "STRING_LEVEL_MODES"}) {
    const LoadResult result =
        loaded(with_string(std::string("frequency_hz: 90 max_level: ") + name));
    CHECK(print_scene(result.loaded->message).find("STRING_LEVEL_WAVE") != std::string::npos);
  }
}

TEST_CASE("modes are played by wave, as many, which is said once") {
  for (const int count : {1, 16, 64}) {
    const LoadResult result =
        loaded(with_string("frequency_hz: 90", "modes { count: " + std::to_string(count) + " }"));
    CHECK(result.loaded->scene->description().instrument.modes == count);
    REQUIRE(result.problems.size() == 1);
    const std::string said = to_text(result.problems.at(0));
    CHECK(said.find(": warning: modes: wave plays it, in " + std::to_string(count) + " modes") !=
          std::string::npos);
    CHECK(result.problems.at(0).line == 4);
  }
}

TEST_CASE("modes beside wave are refused, and both are named") {
  const LoadResult result =
      load_inline(with_string("frequency_hz: 90", "wave { modes: 8 } modes { count: 8 }"));
  CHECK(result.loaded == nullptr);
  const SceneProblem* const fault = find_fault(result.problems, "wave");
  REQUIRE(fault != nullptr);
  CHECK(fault->message.find("modes") != std::string::npos);
}

TEST_CASE("a frequency holds whatever the tension, unless tension tunes") {
  CHECK(
      assigned("frequency_hz: 90", "strings[0].tension_n", 60.0).settings.pieces.at(0).frequency ==
      90.0);
  const AssignmentResult tuned =
      assigned("frequency_hz: 90 tuning: TUNING_TENSION", "strings[0].tension_n", 120.0);
  REQUIRE(tuned.code == v1::RESULT_CODE_OK);
  // Four times 30 N.
  CHECK(derive_string(tuned.settings.pieces.at(0)).frequency == doctest::Approx(180.0));
  CHECK(tuned.scene.strings(0).frequency_hz() == doctest::Approx(180.0));
}

TEST_CASE(
    "a density tunes by tension, live and as clients are told, and beside a frequency one of "
    "them wins") {
  const std::string density = "linear_density_kg_per_m: 0.002 tension_n: 40 ";
  const auto told = [](const std::string& words) {
    const LoadResult result = loaded(with_string(words));
    return std::pair(
        result.loaded->message.strings(0).frequency_hz(),
        derive_string(result.loaded->scene->description().strings.at(0).parameters).frequency);
  };
  const double at_40 = pitch(40.0, 0.002);
  for (const std::string& words : {density, density + "tuning: TUNING_TENSION",
                                   density + "frequency_hz: 85 tuning: TUNING_TENSION"}) {
    CAPTURE(words);
    CHECK(told(words).first == within(at_40, 1e-12));
    CHECK(told(words).second == within(at_40, 1e-12));
    const AssignmentResult live = assigned(words, "strings[0].tension_n", 50.0);
    REQUIRE(live.code == v1::RESULT_CODE_OK);
    CHECK(derive_string(live.settings.pieces.at(0)).frequency == within(pitch(50.0, 0.002), 1e-12));
    CHECK(live.scene.strings(0).frequency_hz() == within(pitch(50.0, 0.002), 1e-12));
  }
  for (const std::string& words :
       {density + "frequency_hz: 85", density + "frequency_hz: 85 tuning: TUNING_FREQUENCY"}) {
    CHECK(told(words) == std::pair(85.0, 85.0));
    CHECK(derive_string(assigned(words, "strings[0].tension_n", 50.0).settings.pieces.at(0))
              .frequency == 85.0);
  }
}

TEST_CASE("which of density and frequency does nothing is said") {
  const std::string both = "linear_density_kg_per_m: 0.002 frequency_hz: 76 ";
  const LoadResult by_frequency = loaded(with_string(both));
  CHECK(doubts(by_frequency, "strings[0].linear_density_kg_per_m").size() == 1);
  CHECK(doubts(by_frequency, "strings[0].frequency_hz").empty());
  const LoadResult by_tension = loaded(with_string(both + "tuning: TUNING_TENSION"));
  CHECK(doubts(by_tension, "strings[0].frequency_hz").size() == 1);
  CHECK(doubts(by_tension, "strings[0].linear_density_kg_per_m").empty());
}

TEST_CASE("a pitch that follows the tension cannot be set, and what a tuning needs is asked for") {
  const AssignmentResult refused =
      assigned("linear_density_kg_per_m: 0.002", "strings[0].frequency_hz", 85.0);
  CHECK(refused.code == v1::RESULT_CODE_INVALID);
  CHECK(refused.message.find("tension_n") != std::string::npos);
  CHECK(assigned("frequency_hz: 90", "strings[0].frequency_hz", 85.0).code == v1::RESULT_CODE_OK);
  for (const char* const words : {"tuning: TUNING_FREQUENCY", "tuning: TUNING_TENSION",
                                  "tuning: TUNING_FREQUENCY linear_density_kg_per_m: 0.002",
                                  "tuning: TUNING_TENSION frequency_hz: 90 tension_n: 0"}) {
    CAPTURE(words);
    const LoadResult result = load_inline(with_string(words));
    CHECK(result.loaded == nullptr);
    CHECK(find_fault(result.problems, "strings[0].tuning") != nullptr);
  }
}

TEST_CASE("a thing to lie on whose name is misspelt is refused with the nearest of the scene") {
  const auto told = [](const std::string& name) {
    const LoadResult result = load_inline(with_string(
        "touch: [\"nut\", \"" + name + "\"]",
        "lines { name: \"nut\" radius_m: 0.001 points_w_m: [0, -0.01, 1, 0, -0.01, 2] }\n"
        "bodies { name: \"board\" shape { spheres { centre_m: [0.1, -0.1, 0.1] "
        "radius_m: 0.05 } } }"));
    CHECK(result.loaded == nullptr);
    const SceneProblem* fault = find_fault(result.problems, "strings[0].touch[1]");
    REQUIRE(fault != nullptr);
    CHECK(fault->line == 2);
    CHECK(fault->message == "'" + name + "' is no line or body");
    return fault->remedy;
  };
  const std::string give = "Give the name of one in the scene.";
  CHECK(told("baord") == give + " Did you mean board?");
  CHECK(told("nutt") == give + " Did you mean nut?");
  CHECK(told("bridge") == give);
}

}  // namespace hapticd::test

// Loading: good scenes play, bad ones are refused with file, line, field and remedy, whatever they
// are, and leave what plays as it was.
#include "server/scene_io/scene_loader.h"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "server/scene_io/message_text.h"
#include "server/scene_io/named_text.h"
#include "server/scene_io/scene_parameters.h"
#include "tests/server/scene_io/full_scene.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

/// A folder that is removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "hapticd_scene_XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path = name;
  }
  ~TemporaryFolder() { fs::remove_all(path); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((path / name).parent_path());
    std::ofstream(path / name, std::ios::binary) << text;
  }
  void write_tree(const std::string& name, const std::vector<Sphere>& leaves) const {
    MeasuredTree file;
    file.tree = build_sphere_tree(leaves);
    for (const std::int32_t spheres : spheres_per_level(file.tree)) {
      file.levels.push_back({spheres, 0.0, 0.0});
    }
    const std::vector<std::uint8_t> bytes = encode_sphere_tree(file);
    write(name, {bytes.begin(), bytes.end()});
  }

  fs::path path;
};

const std::string kFinger =
    "tools { name: \"t\" parts { name: \"p\" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 "
    "} } } pose_wg { p_m: [0, 1, 0] } }\n";

/// A scene whose one body is the tree of this name.
std::string with_tree(const std::string& tree) {
  return "name: \"x\"\n" + kFinger + "bodies {\n  name: \"b\"\n  shape {\n    tree: \"" + tree +
         "\"\n  }\n}\n";
}

LoadOptions looking_in(std::vector<fs::path> scenes, std::vector<fs::path> models) {
  LoadOptions options;
  options.paths = {std::move(scenes), std::move(models)};
  return options;
}

/// What a few ticks give.
std::vector<double> play(Simulation& simulation, std::int64_t& tick, int ticks) {
  std::vector<double> bits;
  SimulationTick output;
  for (int i = 0; i < ticks; ++i, ++tick) {
    const double t = 1e-3 * static_cast<double>(tick);
    const HandPose sample{tick * 1'000'000, {0.0, 0.02 - 0.05 * t, 0.0}, {1.0, 0.0, 0.0, 0.0}};
    output.step(simulation, sample);
    for (const double number : to_array(output.tool(0).F_H_W.f)) bits.push_back(number);
    for (const double number : to_array(output.tool(0).X_WG.p)) bits.push_back(number);
  }
  return bits;
}

}  // namespace

TEST_CASE("a fault names its file, line, column, field, range and remedy") {
  const TemporaryFolder folder;
  folder.write("bad.textproto", "name: \"bad\"\n" + kFinger +
                                    "strings {\n  name: \"s\"\n  p_wa_m: [0, 0, 0]\n  p_wb_m: [1, "
                                    "0, 0]\n  tension_n: -1\n}\n");
  const std::string file = (folder.path / "bad.textproto").string();
  const LoadResult result = load_scene(file, {});
  CHECK(result.loaded == nullptr);
  REQUIRE(result.problems.size() == 1);
  CHECK(to_text(result.problems[0]) ==
        file + ":7:3: error: strings[0].tension_n: -1 is not in [0, 1e6] N.");
}

TEST_CASE("a field that is missing is reported where its message is") {
  const LoadResult result =
      load_inline("name: \"x\"\n" + kFinger + "strings {\n  name: \"s\"\n}\n");
  REQUIRE(result.problems.size() == 1);
  CHECK(result.problems[0].field == "strings[0].p_wa_m");
  CHECK(result.problems[0].line == 3);
  CHECK(!result.problems[0].remedy.empty());
}

TEST_CASE("text that is no scene is refused with the place where it ends to be one") {
  const std::vector<std::pair<std::string, int>> texts{
      {"name: \"x\"\nfoo: 3\n", 2},      {"name: \"x\nbodies", 1},  {"{", 1},
      {"name: \"x\"\n\nname: \"y\"", 3}, {"tools { parts: 3 }", 1}, {"preset: PRESET_NONE", 1}};
  for (const auto& each : texts) {
    CAPTURE(each.first);
    const LoadResult result = load_inline(each.first);
    CHECK(result.loaded == nullptr);
    REQUIRE(!result.problems.empty());
    CHECK(result.problems[0].line == each.second);
    CHECK(result.problems[0].file == "inline");
  }
}

TEST_CASE("texts that are too long, too deep or full of zeros are refused") {
  CHECK(load_inline(std::string(kMaxText + 1, ' ')).loaded == nullptr);
  CHECK(load_inline(std::string(1000, '\0')).loaded == nullptr);
  CHECK(load_inline("").loaded == nullptr);
  std::string deep = "name: \"x\" [a/b] ";
  for (int i = 0; i < 100'000; ++i) deep += "{ a ";
  CHECK(load_inline(deep).loaded == nullptr);
}

TEST_CASE("models are found beside the scene first, then in the folders of models") {
  const TemporaryFolder folder;
  folder.write("scenes/x.textproto", with_tree("a.tree"));
  folder.write_tree("models/a.tree", {{{0.0, 0.0, 0.0}, 0.1}});
  const LoadOptions options = looking_in({folder.path / "scenes"}, {folder.path / "models"});
  const LoadResult installed = load_scene("x", options);
  REQUIRE_MESSAGE(installed.loaded != nullptr, list(installed.problems));
  CHECK(installed.loaded->scene->body_spheres() == 1);
  REQUIRE(installed.loaded->assets.size() == 1);
  CHECK(installed.loaded->assets[0].name == "a.tree");
  folder.write_tree("scenes/a.tree", {{{0.0, 0.0, 0.0}, 0.1}, {{0.1, 0.0, 0.0}, 0.1}});
  const LoadResult beside = load_scene((folder.path / "scenes/x.textproto").string(), options);
  REQUIRE(beside.loaded != nullptr);
  CHECK(beside.loaded->scene->body_spheres() == 2);
  CHECK(beside.loaded->hash != installed.loaded->hash);
  CHECK(list_names(options.paths.scenes) == std::vector<std::string>{"x"});
}

TEST_CASE("no name leads out of the folders, and what is no tree is refused") {
  const TemporaryFolder folder;
  folder.write_tree("secret.tree", {{{0.0, 0.0, 0.0}, 0.1}});
  folder.write("models/text.tree", "this is no tree");
  folder.write("models/empty.tree", "");
  fs::create_directory(folder.path / "models/folder.tree");
  REQUIRE(mkfifo((folder.path / "models/pipe.tree").c_str(), 0600) == 0);
  const LoadOptions options = looking_in({}, {folder.path / "models"});
  for (const std::string& name :
       {std::string("../secret.tree"), (folder.path / "secret.tree").string(), std::string(),
        std::string("a/../../secret.tree"), std::string("none.tree"), std::string("text.tree"),
        std::string("empty.tree"), std::string("folder.tree"), std::string("pipe.tree"),
        std::string("\\000"), std::string(300, 'a')}) {
    CAPTURE(name);
    const LoadResult result = load_scene_text(with_tree(name), options);
    CHECK(result.loaded == nullptr);
    REQUIRE(result.problems.size() == 1);
    CHECK(result.problems[0].field == "bodies[0].shape.tree");
    CHECK(result.problems[0].line == 6);
    CHECK(!result.problems[0].remedy.empty());
  }
}

TEST_CASE("a scene that is not there is answered with those that are") {
  const TemporaryFolder folder;
  folder.write("one.textproto", "");
  const LoadResult result = load_scene("two", looking_in({folder.path}, {}));
  REQUIRE(result.problems.size() == 1);
  CHECK(to_text(result.problems[0]) ==
        "two: error: there is no scene of this name. Installed are one.");
  CHECK(load_scene((folder.path / "none.textproto").string(), {}).loaded == nullptr);
  CHECK(load_scene(folder.path.string() + "/", {}).loaded == nullptr);
}

TEST_CASE("a preset given at loading wins over the scene in the fields presets decide") {
  LoadOptions options;
  options.preset = v1::PRESET_PAPER;
  const LoadResult result = load_scene_text(full_scene_text(), options);
  REQUIRE_MESSAGE(result.loaded != nullptr, list(result.problems));
  const v1::Scene& scene = result.loaded->message;
  CHECK(scene.preset() == v1::PRESET_PAPER);
  for (const v1::String& string : scene.strings()) {
    CHECK(string.model() == v1::STRING_MODEL_RIGID);
    CHECK(string.k_s() == 1.0);
    CHECK(string.touch_decay_s() == string.decay_s());
    CHECK(!string.has_friction_coefficient());
  }
  CHECK(scene.tones().level() == v1::TONE_LEVEL_FORCE);
  CHECK(!scene.has_friction());
  CHECK(!result.loaded->scene->description().instrument.friction);
  for (const v1::Body& body : scene.bodies()) CHECK(body.friction_coefficient() == 0.0);
  for (const v1::Line& line : scene.lines()) CHECK(line.friction_coefficient() == 0.0);
  // What a preset does not decide stays.
  CHECK(scene.strings(0).tension_n() == 40.0);
}

TEST_CASE("the preset of strings that yield leaves friction as the scene says") {
  LoadOptions options;
  options.preset = v1::PRESET_DEFLECTING;
  const LoadResult result = load_scene_text(full_scene_text(), options);
  REQUIRE_MESSAGE(result.loaded != nullptr, list(result.problems));
  CHECK(result.loaded->message.friction().coefficient() == 0.3);
  CHECK(result.loaded->scene->description().instrument.friction);
}

TEST_CASE("a filled scene says all: loaded again it is the same") {
  for (const std::string& text : {full_scene_text(), "name: \"bare\"" + kFinger}) {
    const LoadResult once = load_inline(text);
    REQUIRE_MESSAGE(once.loaded != nullptr, list(once.problems));
    const std::string filled = print_scene(once.loaded->message);
    const LoadResult twice = load_inline(filled);
    REQUIRE_MESSAGE(twice.loaded != nullptr, list(twice.problems));
    CHECK(print_scene(twice.loaded->message) == filled);
  }
}

TEST_CASE("rigid strings have a lateral force but where preset PAPER leaves it out") {
  const std::string paper = "preset: PRESET_PAPER\n";
  for (const auto& each : {std::pair{std::string(), true}, std::pair{paper, false},
                           std::pair{paper + "lateral_force {}\n", true}}) {
    const std::string& text = each.first;
    const bool expected = each.second;
    CAPTURE(text);
    const LoadResult result =
        load_inline(std::string("name: \"bare\"").append(kFinger).append(text));
    REQUIRE(result.loaded != nullptr);
    CHECK(result.loaded->scene->description().instrument.lateral_force == expected);
  }
}

TEST_CASE("features that are absent are not modelled") {
  const LoadResult bare = load_inline("name: \"bare\"" + kFinger);
  REQUIRE(bare.loaded != nullptr);
  const SceneDescription& scene = bare.loaded->scene->description();
  CHECK_FALSE(scene.instrument.vibration);
  CHECK_FALSE(scene.instrument.friction);
  CHECK_FALSE(scene.instrument.pitch_glide);
  CHECK_FALSE(scene.instrument.tones.enabled);
  CHECK(scene.instrument.modes == 0);
  CHECK_FALSE(scene.torque);
  CHECK(bare.loaded->scene->tool_scene(0).limits.torque == 0.0);
  CHECK(bare.loaded->scene->tool_scene(0).parts.parts.empty());
  CHECK_FALSE(bare.loaded->message.has_vibration());
}

TEST_CASE("features that need others are refused without them") {
  const std::string string =
      "strings { name: \"s\" p_wa_m: [0, 0, 0] p_wb_m: [1, 0, 0] max_level: ";
  const auto fault_of = [](const std::string& text, const std::string& path) {
    const LoadResult result = load_inline("name: \"x\"" + kFinger + text);
    CAPTURE(text);
    CHECK(result.loaded == nullptr);
    CHECK(find_fault(result.problems, path) != nullptr);
  };
  fault_of("modes {}", "modes");
  fault_of("wave {}", "wave");
  fault_of(string + "STRING_LEVEL_FUNDAMENTAL }", "strings[0].max_level");
  fault_of("preset: PRESET_PAPER vibration {} " + string + "STRING_LEVEL_WAVE }",
           "strings[0].max_level");
  fault_of("preset: PRESET_PAPER vibration {} " + string + "STRING_LEVEL_MODES }",
           "strings[0].max_level");
  fault_of(
      "strings { name: \"s\" p_wa_m: [0, 0, 0] p_wb_m: [1, 0, 0] sag_m: 0.1 frequency_hz: 50 }",
      "strings[0].sag_m");
  fault_of("strings { name: \"s\" p_wa_m: [0, 0, 0] p_wb_m: [0, 0, 0] sag_m: 0.1 }",
           "strings[0].sag_m");
  fault_of(kFinger, "tools[1].tool_id");
}

TEST_CASE("more strings than can be played are refused, pieces of cables counted") {
  std::string text = "name: \"x\"" + kFinger;
  for (int i = 0; i < 205; ++i) {
    text += "strings { name: \"s\" p_wa_m: [-1, 5, " + std::to_string(i) + "] p_wb_m: [1, 5, " +
            std::to_string(i) + "] sag_m: 0.5 }";
  }
  const LoadResult result = load_inline(text);
  CHECK(result.loaded == nullptr);
  CHECK(find_fault(result.problems, "strings") != nullptr);
}

TEST_CASE("a quality asked for wins over the scene's, its own knobs and no other stand") {
  const std::string scene = "name: \"x\"\n" + kFinger;
  const auto load = [](const std::string& text, const QualityWish& wish) {
    LoadOptions options;
    options.quality = wish;
    LoadResult result = load_scene_text(text, options);
    REQUIRE(result.loaded != nullptr);
    return result.loaded->scene->description();
  };
  QualityWish level;
  level.quality.emplace().set_level(1);
  CHECK(load(scene, {}).quality_level == 3);
  CHECK(load(scene, level).quality_level == 1);
  CHECK(load(scene, level).contact.sub_steps < load(scene, {}).contact.sub_steps);
  CHECK(load(scene + "quality { level: 4 }", {}).quality_level == 4);
  CHECK(load(scene + "quality { level: 4 }", level).quality_level == 1);
  CHECK(load(scene + "solver { max_substeps: 5 }", level).contact.sub_steps == 5);
  CHECK_FALSE(load(scene, level).quality_automatic);
  QualityWish automatic;
  automatic.quality.emplace().mutable_automatic();
  CHECK(load(scene + "quality { level: 4 }", automatic).quality_automatic);
  CHECK(load(scene + "quality { automatic {} }", {}).quality_automatic);
  CHECK_FALSE(load(scene + "quality { automatic {} }", level).quality_automatic);
}

TEST_CASE("the budget is the one asked for, else the scene's, else half the tick") {
  const auto budget = [](const char* quality, const QualityWish& wish) {
    LoadOptions options;
    options.quality = wish;
    const LoadResult result = load_scene_text("name: \"x\"\n" + kFinger + quality, options);
    REQUIRE(result.loaded != nullptr);
    return result.loaded->message.quality().automatic().budget_us();
  };
  QualityWish wish;
  wish.usual_budget_us = 250.0;
  CHECK(budget("quality { automatic {} }", wish) == 250.0);
  CHECK(budget("quality { automatic { budget_us: 70 } }", wish) == 70.0);
  wish.budget_us = 90.0;
  CHECK(budget("quality { automatic { budget_us: 70 } }", wish) == 90.0);
  CHECK(budget("quality { level: 2 }", wish) == 0.0);
  wish.quality.emplace().mutable_automatic();
  CHECK(budget("quality { level: 2 }", wish) == 90.0);
}

TEST_CASE("a scene that is too long to be told to clients is refused with size, limit and remedy") {
  // What is told, by the message alone: scene, hash, assets, parameters.
  const TemporaryFolder folder;
  const auto told = [](const LoadedScene& loaded) {
    v1::SceneInfo info;
    *info.mutable_scene() = loaded.message;
    info.set_hash(std::string(32, 'h'));
    for (const v1::ParameterInfo& each : live_parameters(loaded.message)) {
      *info.add_parameters() = each;
    }
    return info.ByteSizeLong();
  };
  const auto with_points = [](std::size_t points) {
    std::string text =
        "name: \"x\"\n" + kFinger + "lines { name: \"l\" radius_m: 0.001 points_w_m: [1";
    for (std::size_t i = 1; i < 3 * points; ++i) text += i % 2 == 0 ? ",1" : ",2";
    return text + "] }";
  };
  LoadOptions options;
  const LoadResult small = load_scene_text(with_points(2), options);
  REQUIRE_MESSAGE(small.loaded != nullptr, list(small.problems));
  const std::size_t bytes = told(*small.loaded);
  // To the byte: the limit is moved, so that the scene may stay small.
  for (const bool fits : {true, false}) {
    options.longest_info = bytes - (fits ? 0 : 1);
    CHECK((load_scene_text(with_points(2), options).loaded != nullptr) == fits);
  }
  folder.write("x.textproto", with_points(200));
  options.longest_info = 2000;
  const std::string file = (folder.path / "x.textproto").string();
  const LoadResult result = load_scene(file, options);
  CHECK(result.loaded == nullptr);
  CHECK_FALSE(result.missing);
  REQUIRE(result.problems.size() == 1);
  const std::string text = to_text(result.problems[0]);
  CHECK(text.find(file) == 0);
  CHECK(text.find("2000") != std::string::npos);
  CHECK(text.find(std::to_string(bytes + std::size_t{8} * 3 * 198 + 2)) != std::string::npos);
  CHECK(text.find("Put spheres into tree files") != std::string::npos);
  // And as it is: what fits into a blob with all that the daemon adds.
  CHECK(LoadOptions{}.longest_info <= (std::size_t{4} << 20U) - 256);
  CHECK(LoadOptions{}.longest_info >= (std::size_t{4} << 20U) - 4096);
  CHECK(load_scene_text(with_points(180'000), {}).loaded == nullptr);
}

TEST_CASE("a coupling says what is wrong with its axes, and what to do") {
  const auto problem_of = [](const std::string& coupling) {
    const LoadResult result = load_scene_text(
        "name: \"x\"\ntools { name: \"t\" parts { name: \"p\" shape { spheres { centre_m: [0, 0, "
        "0] "
        "radius_m: 0.005 } } }\n  coupling { " +
            coupling + " } }\n",
        {});
    CHECK((result.loaded == nullptr) == !result.problems.empty());
    return result.problems.empty() ? SceneProblem{} : result.problems.front();
  };
  const auto says = [&](const std::string& coupling, const char* field, const char* message) {
    const SceneProblem problem = problem_of(coupling);
    CAPTURE(coupling);
    CAPTURE(problem.message);
    CHECK(problem.line == 3);
    CHECK(problem.field == std::string("tools[0].coupling.") + field);
    CHECK((problem.message + problem.remedy).find(message) != std::string::npos);
  };
  says("kt_n_per_m: 1000 kt_w_n_per_m: [1, 2, 3]", "kt_w_n_per_m", "Drop kt_n_per_m");
  says("length_m: 0.03 kr_g_n_m_per_rad: [1, 2, 3]", "kr_g_n_m_per_rad", "Drop length_m");
  says("kt_w_n_per_m: [1, 2]", "kt_w_n_per_m", "Give 3: x y z.");
  says("kt_w_n_per_m: [1, 2, -3]", "kt_w_n_per_m[2]", "not in [1e-3, 1e9] N/m");
  says("kt_w_n_per_m: [1, 2, 2000]", "kt_w_n_per_m", "more than 1000");
  says("kr_g_n_m_per_rad: [1, 2, 0.001]", "kr_g_n_m_per_rad", "more than 1000");
  says("kr_g_n_m_per_rad: [1e5, 1e5, 1e5]", "kr_g_n_m_per_rad", "Give a smaller");
  says("kr_g_n_m_per_rad: [1e-4, 1e-4, 1e-4]", "kr_g_n_m_per_rad", "Give a larger");
  CHECK(problem_of("kt_w_n_per_m: [1, 2, 1000] length_m: 0.05").message.empty());
  CHECK(problem_of("kt_n_per_m: 500 kr_g_n_m_per_rad: [1, 0.5, 0.001]").message.empty());
}

TEST_CASE("what a scene says of kt is said of the stiffest axis") {
  const LoadResult result = load_scene_text(
      "name: \"x\"\n"
      "tools { name: \"t\" parts { name: \"p\" shape { spheres { centre_m: [0, 0, 0] radius_m: "
      "0.005 "
      "} } } coupling { kt_w_n_per_m: [10, 300, 20] } pose_wg { p_m: [0, 1, 0] } }\n"
      "strings { name: \"A\" p_wa_m: [0, 0, 0] p_wb_m: [1, 0, 0] }\nfriction { coefficient: 0.3 "
      "}\n",
      {});
  REQUIRE(result.loaded != nullptr);
  const v1::Scene& scene = result.loaded->message;
  CHECK(scene.strings(0).contact_stiffness_n_per_m() == 300.0);
  CHECK(scene.friction().anchor_stiffness_n_per_m() == 3000.0);
  const CouplingStiffness& coupling = result.loaded->scene->description().tools[0].coupling;
  CHECK(coupling.kr() == doctest::Approx(300.0 * 0.032 * 0.032));
}

TEST_CASE("a tool that begins inside something is told, and loads") {
  const LoadResult result =
      load_inline("name: \"x\"" + kFinger +
                  "bodies { name: \"b\" shape { spheres { centre_m: [0, 1, 0] radius_m: 0.1 } } }");
  CHECK(result.loaded != nullptr);
  REQUIRE(result.problems.size() == 1);
  CHECK(result.problems[0].doubt);
  CHECK(result.problems[0].field == "tools[0].pose_wg");
}

TEST_CASE("whatever fails to load, the scene that plays goes on to the bit") {
  const std::string text = "name: \"x\"" + kFinger +
                           "strings { name: \"s\" p_wa_m: [-1, 0, 0] p_wb_m: [1, 0, 0] } "
                           "vibration {} torque {}";
  const LoadResult alone = load_inline(text);
  const LoadResult disturbed = load_inline(text);
  REQUIRE(alone.loaded != nullptr);
  const OwnedSimulation a = alone.loaded->scene->simulate(0);
  const OwnedSimulation b = disturbed.loaded->scene->simulate(0);
  std::int64_t tick_a = 0;
  std::int64_t tick_b = 0;
  SplitMix64 random(1);
  for (int round = 0; round < 10; ++round) {
    std::string bad = full_scene_text();
    for (int k = 0; k < 3; ++k) bad[random.below(bad.size())] = static_cast<char>(random.next());
    static_cast<void>(load_inline(bad));
    CHECK(play(*a.simulation, tick_a, 100) == play(*b.simulation, tick_b, 100));
  }
}

}  // namespace hapticd::test

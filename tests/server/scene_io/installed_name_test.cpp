// Names that peers give: whatever they are, no file outside the folders is opened, and no answer
// tells whether there is one or what is in it. Judged by the kernel, which reports every opening of
// a file outside, and by what the answers say.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <memory>

#include "server/scene_io/gesture_loader.h"
#include "server/scene_io/named_text.h"
#include "server/scene_io/scene_loader.h"
#include "tests/server/scene_io/full_scene.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

/// What only files outside say.
const std::string kSecret = "word_of_a_secret";

/// What stands beside the folders, and who opens it.
class House {
 public:
  House() {
    std::string name = (fs::temp_directory_path() / "hapticd_names_XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    root = name;
    write("scenes/good.textproto", "name: \"good\"\n" + kOneSphereTool);
    write("scenes/.hidden.textproto", "name: \"" + kSecret + "\"\n" + kOneSphereTool);
    for (const std::string& odd : {std::string("Good"), std::string("go od"), std::string("go.od"),
                                   std::string("g\xc3\xb6od"), std::string(65, 'a')}) {
      write(std::string("scenes/").append(odd).append(".textproto"),
            std::string("name: \"").append(kSecret).append("\"\n").append(kOneSphereTool));
    }
    write("gestures/wave.textproto", "name: \"wave\" tracks { waypoints { pose_wh {} } }");
    write("models/a.txt", "no tree");
    write("outside/scene.textproto", "name: \"" + kSecret + "\"\n" + kOneSphereTool);
    write("outside/gesture.textproto", "name: \"" + kSecret + "\"");
    write("outside/private.txt", kSecret + ": 42\n");
    write("outside/private.textproto", kSecret + ": 42\n");
    watch_ = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
    REQUIRE(watch_ >= 0);
    const fs::path outside = root / "outside";
    REQUIRE(inotify_add_watch(watch_, outside.c_str(), IN_OPEN | IN_ACCESS) >= 0);
    options.paths = {{root / "scenes"}, {root / "models"}};
  }
  ~House() {
    close(watch_);
    fs::remove_all(root);
  }
  House(const House&) = delete;
  House& operator=(const House&) = delete;

  /// Whether anything outside was opened since the last call.
  [[nodiscard]] bool opened_outside() const {
    std::array<char, 4096> events{};
    return read(watch_, events.data(), events.size()) > 0;
  }
  /// All that is said of a name, scene or gesture or model; what is loaded has to be from inside.
  [[nodiscard]] std::string answers(const std::string& name) const {
    const LoadResult scene = load_installed_scene(name, options);
    if (scene.loaded != nullptr) CHECK(scene.loaded->message.name() == "good");
    const GestureResult gesture = load_installed_gesture(name, {root / "gestures"});
    if (gesture.gesture) CHECK(gesture.gesture->name() == "wave");
    v1::Scene inline_scene;
    inline_scene.set_name("x");
    inline_scene.add_bodies()->set_name("b");
    inline_scene.mutable_bodies(0)->mutable_shape()->set_tree(name);
    const std::string text = kOneSphereTool + print_scene(inline_scene);
    // A file that a peer has brought by this name is no tree, and opens nothing.
    LoadOptions with_file = options;
    with_file.brought.emplace(name, std::make_shared<const BroughtFile>());
    const LoadResult brought = load_scene_text(text, with_file);
    CHECK(brought.loaded == nullptr);
    return list(scene.problems) + "\n" + list(gesture.problems) + "\n" +
           list(load_scene_text(text, options).problems) + "\n" + list(brought.problems);
  }

  fs::path root;
  LoadOptions options;

 private:
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((root / name).parent_path());
    std::ofstream(root / name, std::ios::binary) << text;
  }
  int watch_ = -1;
};

/// `text` with every `from` as `to`.
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at)) {
    text.replace(at, from.size(), to);
    at += to.size();
  }
  return text;
}

}  // namespace

TEST_CASE("the judge sees who opens a file outside") {
  const House house;
  CHECK_FALSE(house.opened_outside());
  CHECK(load_scene((house.root / "outside/scene.textproto").string(), house.options).loaded);
  CHECK(house.opened_outside());
  CHECK_FALSE(house.opened_outside());
}

TEST_CASE("names of installed files are found, and nothing else is a name") {
  const House house;
  CHECK(load_installed_scene("good", house.options).loaded);
  CHECK(load_installed_gesture("wave", {house.root / "gestures"}).gesture);
  for (const std::string& name : {(house.root / "outside/scene").string(),
                                  (house.root / "outside/scene.textproto").string(),
                                  std::string("../outside/scene"),
                                  std::string("../outside/scene.textproto"),
                                  std::string("./good"),
                                  std::string("../scenes/good"),
                                  std::string("/etc/passwd"),
                                  std::string(".hidden"),
                                  std::string("good.textproto"),
                                  std::string("."),
                                  std::string(".."),
                                  std::string(),
                                  std::string("good\0", 5),
                                  std::string("go\nod"),
                                  std::string("\x1b[31m"),
                                  std::string("Good"),
                                  std::string("go od"),
                                  std::string("go.od"),
                                  std::string("g\xc3\xb6od"),
                                  std::string(65, 'a'),
                                  std::string(100'000, 'a'),
                                  std::string(100'000, '/')}) {
    CAPTURE(name.substr(0, 300));
    const LoadResult scene = load_installed_scene(name, house.options);
    CHECK(scene.loaded == nullptr);
    CHECK(scene.missing);
    REQUIRE(scene.problems.size() == 1);
    CHECK(to_text(scene.problems[0]).size() < 400);
    CHECK_FALSE(scene.problems[0].remedy.empty());
    CHECK_FALSE(load_installed_gesture(name, {house.root / "gestures"}).gesture);
    CHECK_FALSE(house.opened_outside());
  }
}

TEST_CASE("what is listed can be named, and every name of 1 to 64 of a-z 0-9 _ - is one") {
  const House house;
  CHECK(list_names(house.options.paths.scenes) == std::vector<std::string>{"good"});
  for (int c = 0; c < 256; ++c) {
    const std::string name(1, static_cast<char>(c));
    CAPTURE(c);
    CHECK(fault_of_name(name).empty() ==
          (std::string_view("abcdefghijklmnopqrstuvwxyz0123456789_-").find(name) !=
           std::string_view::npos));
  }
  CHECK(fault_of_name(std::string(64, 'z')).empty());
  CHECK_FALSE(fault_of_name(std::string(65, 'z')).empty());
}

TEST_CASE("the owner of the machine, who may give a path, is told to") {
  const House house;
  const LoadResult named = load_scene("Good", house.options);
  REQUIRE(named.problems.size() == 1);
  CHECK(to_text(named.problems[0]).find("path") != std::string::npos);
  CHECK(load_scene((house.root / "scenes/Good.textproto").string(), house.options).loaded);
}

TEST_CASE("no name of a random cloud opens or tells anything outside the folders") {
  const House house;
  const std::string root = house.root.string();
  SplitMix64 random(31);
  const std::array<std::string, 22> pieces{
      "/",        "..",        ".",       "//",         "outside",
      "scene",    "private",   "gesture", ".textproto", ".txt",
      "scenes",   "good",      root,      root + "/",   "models",
      "a.txt",    "%2e%2e%2f", "\\",      "\x01",       std::string(1, '\0'),
      "\xc3\xa4", ".hidden"};
  const std::array<std::string, 4> twins{"outside", "private", "scene", "gesture"};
  const std::int64_t count = scaled(20'000);
  for (std::int64_t i = 0; i < count; ++i) {
    std::string name;
    const std::uint64_t length = 1 + random.below(9);
    for (std::uint64_t k = 0; k < length; ++k) name += pieces[random.below(pieces.size())];
    if (random.chance(0.2)) name = root + "/outside/private" + (random.chance(0.5) ? ".txt" : "");
    if (random.chance(0.02)) name += std::string(random.below(300), 'a');
    CAPTURE(name);
    const std::string answers = house.answers(name);
    CHECK_FALSE(house.opened_outside());
    CHECK(answers.find(kSecret) == std::string::npos);
    for (const char c : answers) CHECK((c == '\n' || static_cast<unsigned char>(c) >= 0x20U));
    // Where a file outside is named the answer is that for one which is not there.
    for (const std::string& twin : twins) {
      if (name.find(twin) == std::string::npos) continue;
      const std::string other(twin.size(), 'q');
      CHECK(replaced(answers, twin, other) ==
            replaced(house.answers(replaced(name, twin, other)), twin, other));
    }
  }
}

}  // namespace hapticd::test

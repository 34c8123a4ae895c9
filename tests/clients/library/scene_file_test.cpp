// What is read of a scene's file: the files beside it that it names and nothing else. A server that
// forgets what it was sent is not sent it for ever. That files arrive,
// tests/system/brought_scene_test.py says.
#include "clients/library/scene_file.h"

#include <doctest/doctest.h>

#include <fstream>
#include <string>

#include "tests/clients/library/real_server.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

/// A folder that is removed at the end.
class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "hapticd_scene_file_XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    root = name;
    path = root / "own";
    fs::create_directories(path / "parts");
  }
  ~Folder() { fs::remove_all(root); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path / name, std::ios::binary) << bytes;
  }
  [[nodiscard]] client::SceneFile read(const std::string& text) const {
    return client::read_scene_file(path / "x.textproto", text);
  }
  [[nodiscard]] std::string fault_of(const std::string& text) const {
    try {
      static_cast<void>(read(text));
    } catch (const std::runtime_error& fault) {
      return fault.what();
    }
    return "";
  }
  fs::path root;
  fs::path path;
};

std::string body(const std::string& shape) {
  return "bodies {\n  name: \"b\"\n  shape { " + shape + " }\n}\n";
}

}  // namespace

TEST_CASE("the files that a scene names are read where they stand beside it, each once") {
  const Folder folder;
  folder.write("a.tree", "tree");
  folder.write("parts/a.ply", "mesh");
  folder.write("unnamed.tree", "other");
  const client::SceneFile scene =
      folder.read("tools { parts { shape { mesh: \"parts/a.ply\" } } }\n" +
                  body("tree: \"a.tree\" mesh: \"installed.ply\"") +
                  body("tree: \"a.tree\" mesh: \"parts/a.ply\"") + "field_of_later: 3\n");
  REQUIRE(scene.assets.size() == 2);
  CHECK(scene.assets[0].name == "parts/a.ply");
  CHECK(scene.assets[0].bytes == "mesh");
  CHECK(scene.assets[1].name == "a.tree");
  const v1::Item item = client::load_request(scene);
  CHECK(item.load_scene().text() == scene.text);
  CHECK(item.load_scene().assets(1).name() == "a.tree");
  CHECK(item.load_scene().assets(1).hash().size() == 32);
}

TEST_CASE("a text that is no scene, or a name that leads out of the folder, has no file") {
  const Folder folder;
  std::ofstream(folder.root / "secret.tree") << "secret";
  folder.write("a.tree", "tree");
  CHECK(folder.read("tools { " + body("tree: \"a.tree\"")).assets.empty());
  for (const std::string& name :
       {std::string("../secret.tree"), std::string("parts/../../secret.tree"),
        (folder.root / "secret.tree").string(), std::string("\\033[31m")}) {
    CHECK(folder.read(body("tree: \"" + name + "\"")).assets.empty());
  }
}

TEST_CASE("a file that cannot be sent is named with the scene, its line and the remedy") {
  const Folder folder;
  const std::string place = (folder.path / "x.textproto").string() + ":3: 'a.tree' ";
  folder.write("a.tree", "");
  CHECK(folder.fault_of(body("tree: \"a.tree\"")) == place + "is empty");
  fs::resize_file(folder.path / "a.tree", client::kMaxSceneAssets + 1);
  const std::string fault = folder.fault_of(body("tree: \"a.tree\""));
  CHECK(fault.starts_with(place));
  CHECK(fault.find("67108864 bytes. Make coarser") != std::string::npos);
  fs::remove(folder.path / "a.tree");
  fs::create_directory(folder.path / "a.tree");
  CHECK(folder.fault_of(body("tree: \"a.tree\"")) == place + "is not a file");
}

TEST_CASE("a server that forgets what it was sent is given up") {
  RealServer server;
  client::Client client("127.0.0.1", server.port());
  client::Controller controller(client);
  REQUIRE(controller.acquire("test").code() == v1::RESULT_CODE_OK);
  client::SceneFile scene;
  scene.assets.push_back({"a.tree", std::string(32, 'h'), std::string(100'000, 'x')});
  std::size_t heard = 0;
  const v1::Result result = client::bring_assets(
      controller, scene, [&](const client::SceneAssetFile&, std::size_t there, std::size_t all) {
        CHECK(there == 0);
        CHECK(all == 100'000);
        ++heard;
      });
  CHECK(result.code() == v1::RESULT_CODE_FAILED);
  CHECK(result.message().find("a.tree") != std::string::npos);
  CHECK(heard == 1);
}

}  // namespace hapticd::test

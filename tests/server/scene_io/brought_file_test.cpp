// Files of a scene that a peer has brought: the scene is the one that is loaded beside them, and a
// name that has such a file is looked for in no folder.
#include "server/scene_io/brought_file.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "core/scene/scene.h"
#include "core/tree/sphere_tree.h"
#include "server/scene_io/scene_loader.h"
#include "server/scene_io/sphere_tree_file.h"
#include "tests/server/scene_io/full_scene.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

const std::string kStone =
    "name: \"stone\"\n" + kOneSphereTool +
    "bodies { name: \"b\" shape { tree: \"parts/stone.tree\" mesh: \"stone.ply\" } }\n";

std::vector<std::uint8_t> random_tree(std::uint64_t seed) {
  SplitMix64 random(seed);
  std::vector<Sphere> leaves(40);
  for (Sphere& leaf : leaves) {
    leaf = {{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), 0.0},
            random.uniform(0.001, 0.01)};
  }
  MeasuredTree file;
  file.tree = build_sphere_tree(leaves);
  for (const std::int32_t spheres : spheres_per_level(file.tree)) {
    file.levels.push_back({spheres, 0.0, 0.0});
  }
  return encode_sphere_tree(file);
}

std::shared_ptr<const BroughtFile> brought(const std::vector<std::uint8_t>& bytes) {
  auto file = std::make_shared<BroughtFile>();
  file->hash = content_hash(bytes);
  file->size = bytes.size();
  for (std::size_t at = 0; at < bytes.size(); at += 1000) {
    const std::size_t end = std::min(at + 1000, bytes.size());
    file->pieces.emplace_back(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                              bytes.begin() + static_cast<std::ptrdiff_t>(end));
  }
  return file;
}

/// A folder that is removed at the end.
class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "hapticd_brought_XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path = name;
    fs::create_directories(path / "parts");
  }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  void write(const std::string& name, const std::vector<std::uint8_t>& bytes) const {
    std::ofstream(path / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  fs::path path;
};

const std::vector<std::uint8_t> kMesh{'p', 'l', 'y'};

}  // namespace

TEST_CASE("a scene with the files that were brought is the one that is loaded beside them") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Folder folder;
    folder.write("parts/stone.tree", random_tree(seed));
    folder.write("stone.ply", kMesh);
    std::ofstream(folder.path / "stone.textproto") << kStone;
    const LoadResult local = load_scene((folder.path / "stone.textproto").string(), {});
    REQUIRE_MESSAGE(local.loaded != nullptr, list(local.problems));
    LoadOptions options;
    options.brought = {{"parts/stone.tree", brought(random_tree(seed))},
                       {"stone.ply", brought(kMesh)}};
    const LoadResult sent = load_scene_text(kStone, options);
    REQUIRE_MESSAGE(sent.loaded != nullptr, list(sent.problems));
    CHECK(describe_scene(*sent.loaded).SerializeAsString() ==
          describe_scene(*local.loaded).SerializeAsString());
    CHECK(sent.loaded->brought == options.brought);
    options.brought["stone.ply"] = brought({'P', 'l', 'y'});
    CHECK(load_scene_text(kStone, options).loaded->hash != local.loaded->hash);
  }
}

TEST_CASE("a file that was brought comes before an installed one, and others are found there") {
  const Folder folder;
  folder.write("parts/stone.tree", {'n', 'o'});
  folder.write("stone.ply", kMesh);
  LoadOptions options;
  options.paths.models = {folder.path};
  CHECK(load_scene_text(kStone, options).loaded == nullptr);
  options.brought = {{"parts/stone.tree", brought(random_tree(4))}};
  const LoadResult mixed = load_scene_text(kStone, options);
  REQUIRE_MESSAGE(mixed.loaded != nullptr, list(mixed.problems));
  CHECK(mixed.loaded->assets[1].hash == content_hash(kMesh));
}

TEST_CASE("a file that was brought and is no tree is refused with its line") {
  LoadOptions options;
  options.brought = {{"parts/stone.tree", brought({'n', 'o'})}, {"stone.ply", brought(kMesh)}};
  const LoadResult result = load_scene_text(kStone, options);
  CHECK(result.loaded == nullptr);
  const SceneProblem* fault = find_fault(result.problems, "bodies[0].shape.tree");
  REQUIRE(fault != nullptr);
  CHECK(fault->line == 3);
  CHECK(fault->message.find("'parts/stone.tree' is not a sphere-tree") != std::string::npos);
}

TEST_CASE("a name that leads out of the folders is none, brought or not") {
  for (const std::string& name : {std::string("../stone.tree"), std::string("/tmp/stone.tree"),
                                  std::string("a/../../b"), std::string("a\x1b[31m.tree")}) {
    LoadOptions options;
    options.brought = {{name, brought(random_tree(5))}};
    v1::Scene scene;
    scene.set_name("x");
    scene.add_bodies()->set_name("b");
    scene.mutable_bodies(0)->mutable_shape()->set_tree(name);
    const LoadResult result = load_scene_text(kOneSphereTool + print_scene(scene), options);
    CHECK(result.loaded == nullptr);
    CHECK(list(result.problems).find("does not name a file below") != std::string::npos);
  }
}

}  // namespace hapticd::test

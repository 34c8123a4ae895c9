// See scene_file.h.
#include "clients/library/scene_file.h"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>
#include <sodium.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "hapticd/v1/scene.pb.h"
#include "proto/wire/shown_text.h"

namespace hapticd::client {
namespace {

namespace fs = std::filesystem;
namespace pb = google::protobuf;

constexpr std::size_t kHashBytes = 32;
constexpr const char* kSmaller =
    "Make coarser sphere-trees or meshes, or install them on the machine of hapticd";

/// Says nothing: the server judges the text.
class Silent : public pb::io::ErrorCollector {
 public:
  void AddError(int /*line*/, int /*column*/, const std::string& /*message*/) override {}
  void AddWarning(int /*line*/, int /*column*/, const std::string& /*message*/) override {}
};

/// A name in a scene's text.
struct NamedFile {
  std::string name;
  int line = 0;  ///< counts from 1
};

using Places = pb::TextFormat::ParseInfoTree;

/// The names of `shape`, whose fields are at `places`.
void add_names(const v1::Shape& shape, const Places* places, std::vector<NamedFile>& names) {
  const auto add = [&](const std::string& name, int number) {
    const bool known = std::any_of(names.begin(), names.end(),
                                   [&](const NamedFile& each) { return each.name == name; });
    if (name.empty() || known) return;
    const pb::FieldDescriptor* field = v1::Shape::descriptor()->FindFieldByNumber(number);
    names.push_back({name, places == nullptr ? 0 : places->GetLocation(field, -1).line + 1});
  };
  add(shape.tree(), v1::Shape::kTreeFieldNumber);
  add(shape.mesh(), v1::Shape::kMeshFieldNumber);
}

/// Where the fields of a message are that is in another one.
template <typename Outer>
const Places* nested(const Places* places, int number, int index) {
  if (places == nullptr) return nullptr;
  return places->GetTreeForNested(Outer::descriptor()->FindFieldByNumber(number), index);
}

std::vector<NamedFile> names_in(const std::string& text) {
  v1::Scene scene;
  Places places;
  Silent silent;
  pb::TextFormat::Parser parser;
  parser.RecordErrorsTo(&silent);
  parser.WriteLocationsTo(&places);
  parser.AllowUnknownField(true);
  if (!parser.ParseFromString(text, &scene)) return {};
  std::vector<NamedFile> names;
  for (int k = 0; k < scene.tools_size(); ++k) {
    const Places* tool = nested<v1::Scene>(&places, v1::Scene::kToolsFieldNumber, k);
    for (int n = 0; n < scene.tools(k).parts_size(); ++n) {
      const Places* part = nested<v1::Tool>(tool, v1::Tool::kPartsFieldNumber, n);
      add_names(scene.tools(k).parts(n).shape(),
                nested<v1::ToolPart>(part, v1::ToolPart::kShapeFieldNumber, -1), names);
    }
  }
  for (int k = 0; k < scene.bodies_size(); ++k) {
    const Places* body = nested<v1::Scene>(&places, v1::Scene::kBodiesFieldNumber, k);
    add_names(scene.bodies(k).shape(), nested<v1::Body>(body, v1::Body::kShapeFieldNumber, -1),
              names);
  }
  return names;
}

/// True for names that stay below the scene's folder, as the server has it with its own.
bool stays_below(const std::string& name) {
  const fs::path path(name);
  return wire::is_plain(name) && path.is_relative() &&
         std::none_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

/// All of a regular file with at most `largest` bytes; throws std::runtime_error that says why not.
std::string bytes_of(const fs::path& path, std::size_t largest) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) throw std::runtime_error("is not a file");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw std::runtime_error(error.message());
  if (size == 0) throw std::runtime_error("is empty");
  if (size > largest) {
    throw std::runtime_error("and those before it have more than " +
                             std::to_string(kMaxSceneAssets) + " bytes. " + kSmaller);
  }
  std::string bytes(static_cast<std::size_t>(size), '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(std::generic_category().message(errno));
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (file.gcount() != static_cast<std::streamsize>(bytes.size())) {
    throw std::runtime_error("cannot be read");
  }
  return bytes;
}

std::string hash_of(const std::string& bytes) {
  std::string hash(kHashBytes, '\0');
  if (sodium_init() < 0 ||
      crypto_generichash(reinterpret_cast<std::uint8_t*>(hash.data()), hash.size(),
                         reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), nullptr,
                         0) != 0) {
    throw std::runtime_error("the hash of libsodium does not work on this machine");
  }
  return hash;
}

v1::Result bring(Controller& controller, const SceneAssetFile& asset, const AssetProgress& progress,
                 std::chrono::nanoseconds timeout) {
  v1::Item item;
  v1::PutAsset& put = *item.mutable_put_asset();
  put.set_hash(asset.hash);
  put.set_size(static_cast<std::uint32_t>(asset.bytes.size()));
  std::size_t least = 0;
  while (true) {
    v1::Result result = controller.call(item, timeout);
    if (result.code() != v1::RESULT_CODE_OK) return result;
    const std::size_t there = result.asset().received();
    if (there < least) {
      result.set_code(v1::RESULT_CODE_FAILED);
      result.set_message("hapticd has forgotten what it had of '" + asset.name + "'. Try again");
      return result;
    }
    if (progress) progress(asset, there, asset.bytes.size());
    if (there >= asset.bytes.size()) return result;
    put.set_offset(static_cast<std::uint32_t>(there));
    put.set_bytes(asset.bytes.substr(there, kAssetPiece));
    least = there + put.bytes().size();
  }
}

}  // namespace

SceneFile read_scene_file(const fs::path& path, std::string text) {
  SceneFile scene;
  std::size_t left = kMaxSceneAssets;
  for (const NamedFile& named : names_in(text)) {
    std::error_code ignored;
    const fs::path file = path.parent_path() / named.name;
    if (!stays_below(named.name) || !fs::exists(file, ignored)) continue;
    const std::string place =
        path.string() + ":" + std::to_string(named.line) + ": '" + named.name + "' ";
    if (scene.assets.size() >= kMaxNamedAssets) {
      throw std::runtime_error(place + "is more than the 256th file. " + kSmaller);
    }
    try {
      std::string bytes = bytes_of(file, left);
      left -= bytes.size();
      std::string hash = hash_of(bytes);
      scene.assets.push_back({named.name, std::move(hash), std::move(bytes)});
    } catch (const std::runtime_error& fault) {
      throw std::runtime_error(place + fault.what());
    }
  }
  scene.text = std::move(text);
  return scene;
}

v1::Item load_request(const SceneFile& scene) {
  v1::Item item;
  v1::LoadScene& load = *item.mutable_load_scene();
  load.set_text(scene.text);
  for (const SceneAssetFile& asset : scene.assets) {
    v1::BroughtAsset& brought = *load.add_assets();
    brought.set_name(asset.name);
    brought.set_hash(asset.hash);
  }
  return item;
}

v1::Result bring_assets(Controller& controller, const SceneFile& scene,
                        const AssetProgress& progress, std::chrono::nanoseconds timeout) {
  v1::Result result;
  result.set_code(v1::RESULT_CODE_OK);
  for (const SceneAssetFile& asset : scene.assets) {
    result = bring(controller, asset, progress, timeout);
    if (result.code() == v1::RESULT_CODE_UNSUPPORTED) {
      result.set_message("this hapticd is of a version that takes no files of scenes. Install '" +
                         asset.name + "' in its folder of models");
    }
    if (result.code() != v1::RESULT_CODE_OK) break;
  }
  return result;
}

}  // namespace hapticd::client

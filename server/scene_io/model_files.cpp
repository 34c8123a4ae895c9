// See model_files.h.
#include "server/scene_io/model_files.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace hapticd {
namespace {

namespace fs = std::filesystem;

/// Longest name of a file, bytes.
constexpr std::size_t kMaxName = 256;

/// Whether people can be shown the name: short enough, without control characters.
bool can_be_shown(const std::string& name) {
  return name.size() <= kMaxName && std::none_of(name.begin(), name.end(), [](char c) {
           return static_cast<unsigned char>(c) < 0x20U || c == '\x7f';
         });
}

/// True for names that stay below a folder.
bool stays_below(const std::string& name) {
  if (name.empty() || !can_be_shown(name)) return false;
  const fs::path path(name);
  return path.is_relative() &&
         std::none_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

}  // namespace

ScenePaths installed_paths() {
  fs::path root;
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody changes the environment
  if (const char* data = std::getenv("HAPTICD_DATA"); data != nullptr && *data != '\0') {
    root = data;
  } else {
    std::error_code ignored;
    root = fs::read_symlink("/proc/self/exe", ignored).parent_path().parent_path() / "share" /
           "hapticd";
  }
  return {{root / "scenes"}, {root / "models"}};
}

std::vector<std::uint8_t> read_file(const fs::path& path, std::uintmax_t largest) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) throw std::runtime_error("is not a file");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw std::runtime_error(error.message());
  if (size > largest) {
    throw std::runtime_error("has " + std::to_string(size) + " bytes, more than " +
                             std::to_string(largest));
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw std::runtime_error("cannot be read: " + std::generic_category().message(errno));
  }
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file || file.gcount() != static_cast<std::streamsize>(bytes.size())) {
    throw std::runtime_error("cannot be read");
  }
  return bytes;
}

std::vector<std::uint8_t> ModelFiles::read(const std::string& name) const {
  if (!stays_below(name)) {
    throw std::runtime_error((can_be_shown(name) ? "'" + name + "'" : std::string("this")) +
                             " does not name a file below the folders of models (" +
                             folder_names() + ")");
  }
  if (const auto found = brought_.find(name); found != brought_.end()) {
    return found->second->bytes();
  }
  for (const fs::path& folder : folders_) {
    std::error_code ignored;
    const fs::path path = folder / name;
    if (!fs::exists(path, ignored)) continue;
    try {
      return read_file(path, kMaxModelFile);
    } catch (const std::runtime_error& fault) {
      throw std::runtime_error("'" + name + "' " + fault.what());
    }
  }
  throw std::runtime_error("there is no file '" + name + "' in the folders of models (" +
                           folder_names() + ")");
}

std::string ModelFiles::folder_names() const {
  std::string text;
  for (const fs::path& folder : folders_) text += (text.empty() ? "" : ", ") + folder.string();
  return text.empty() ? "there are none" : text;
}

void ModelFiles::note(const std::string& name, const std::vector<std::uint8_t>& bytes) {
  assets_.push_back({name, content_hash(bytes), bytes.size()});
}

std::shared_ptr<const MeasuredTree> ModelFiles::tree(const std::string& name) {
  if (const auto known = trees_.find(name); known != trees_.end()) return known->second;
  const std::vector<std::uint8_t> bytes = read(name);
  try {
    auto tree = std::make_shared<const MeasuredTree>(decode_sphere_tree(bytes));
    note(name, bytes);
    trees_.emplace(name, tree);
    return tree;
  } catch (const std::runtime_error& fault) {
    throw std::runtime_error("'" + name + "' is not a sphere-tree: " + fault.what());
  }
}

void ModelFiles::note_mesh(const std::string& name) {
  const bool known = std::any_of(assets_.begin(), assets_.end(),
                                 [&](const SceneAsset& asset) { return asset.name == name; });
  if (!known) note(name, read(name));
}

}  // namespace hapticd

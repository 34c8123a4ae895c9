// See asset_store.h.
#include "clients/web/gateway/asset_store.h"

#include <sodium.h>

#include <array>
#include <fstream>
#include <system_error>
#include <utility>

namespace hapticd::web {
namespace {

namespace fs = std::filesystem;

/// Least time between two looks through the folders, ns: a page may ask for anything.
constexpr std::int64_t kLookAgain_ns = 1'000'000'000;

bool is_asset(const fs::directory_entry& entry) {
  std::error_code unknown;
  return entry.is_regular_file(unknown) && !entry.is_symlink(unknown) &&
         entry.file_size(unknown) <= kMaxAssetBytes;
}

}  // namespace

std::string hash_of(std::string_view bytes) {
  std::array<unsigned char, 32> hash{};
  crypto_generichash_blake2b(hash.data(), hash.size(),
                             reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
                             nullptr, 0);
  std::string text(2 * hash.size() + 1, '\0');
  sodium_bin2hex(text.data(), text.size(), hash.data(), hash.size());
  text.pop_back();
  return text;
}

std::optional<std::string> read_whole(const fs::path& file) {
  std::error_code unknown;
  const std::uintmax_t size = fs::file_size(file, unknown);
  if (unknown || size > kMaxAssetBytes) return std::nullopt;
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size))) return std::nullopt;
  return bytes;
}

AssetStore::AssetStore(std::vector<fs::path> folders) : folders_(std::move(folders)) { look(); }

void AssetStore::look() {
  for (const fs::path& folder : folders_) {
    std::error_code unknown;
    fs::recursive_directory_iterator entries(folder, fs::directory_options::skip_permission_denied,
                                             unknown);
    for (; !unknown && entries != fs::recursive_directory_iterator(); entries.increment(unknown)) {
      if (!is_asset(*entries)) continue;
      const fs::path& path = entries->path();
      std::error_code gone;
      const auto changed = entries->last_write_time(gone);
      const auto known = seen_.find(path);
      if (gone || (known != seen_.end() && known->second == changed)) continue;
      const auto bytes = read_whole(path);
      if (!bytes.has_value()) continue;
      files_[hash_of(*bytes)] = path;
      seen_[path] = changed;
    }
  }
}

std::optional<std::string> AssetStore::find(const std::string& hash, std::int64_t now_ns) {
  auto found = files_.find(hash);
  if (found == files_.end() && hash.size() == 64 && now_ns - looked_ns_ >= kLookAgain_ns) {
    looked_ns_ = now_ns;
    look();
    found = files_.find(hash);
  }
  if (found == files_.end()) return std::nullopt;
  auto bytes = read_whole(found->second);
  if (!bytes.has_value() || hash_of(*bytes) != hash) {
    files_.erase(found);
    return std::nullopt;
  }
  return bytes;
}

}  // namespace hapticd::web

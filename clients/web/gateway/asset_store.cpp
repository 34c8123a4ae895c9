// See asset_store.h.
#include "clients/web/gateway/asset_store.h"

#include <system_error>
#include <utility>

namespace hapticd::web {
namespace {

namespace fs = std::filesystem;

/// Least time between two looks through the folders, ns: a page may ask for anything.
constexpr std::int64_t kLookAgain_ns = 1'000'000'000;

}  // namespace

AssetStore::AssetStore(std::vector<fs::path> folders) : folders_(std::move(folders)) {}

void AssetStore::read(const fs::path& path) {
  const auto file = OpenFile::at(path);
  if (!file.has_value()) return;
  Seen& known = seen_[path];
  if (known.digest != nullptr && known.stamp == file->stamp()) {
    // Another file of the same content may have gone.
    files_.try_emplace(known.digest->hash, path);
    return;
  }
  auto digest = file->digest();
  if (!digest.has_value()) return;
  files_[digest->hash] = path;
  known = {file->stamp(), std::make_shared<const FileDigest>(std::move(*digest))};
}

void AssetStore::look() {
  looked_ = true;
  for (const fs::path& folder : folders_) {
    std::error_code unknown;
    fs::recursive_directory_iterator entries(folder, fs::directory_options::skip_permission_denied,
                                             unknown);
    for (; !unknown && entries != fs::recursive_directory_iterator(); entries.increment(unknown)) {
      std::error_code gone;
      if (entries->is_regular_file(gone)) read(entries->path());
    }
  }
}

std::shared_ptr<const CheckedFile> AssetStore::find(const std::string& hash, std::int64_t now_ns) {
  if (!looked_) look();
  auto found = files_.find(hash);
  if (found == files_.end() && hash.size() == 64 && now_ns - looked_ns_ >= kLookAgain_ns) {
    looked_ns_ = now_ns;
    look();
    found = files_.find(hash);
  }
  if (found == files_.end()) return nullptr;
  const fs::path path = found->second;
  read(path);
  auto file = OpenFile::at(path);
  const Seen& seen = seen_[path];
  const bool same = file.has_value() && seen.digest != nullptr && seen.digest->hash == hash &&
                    seen.stamp == file->stamp();
  if (same) return std::make_shared<const CheckedFile>(std::move(*file), seen.digest);
  files_.erase(hash);
  return nullptr;
}

}  // namespace hapticd::web

// See asset_desk.h.
#include "server/daemon/asset_desk.h"

#include <algorithm>
#include <array>

#include "proto/wire/request_result.h"

namespace hapticd {
namespace {

using wire::result_of;

/// Longest name of a file, bytes.
constexpr std::size_t kMaxName = 256;

bool is_hash(const std::string& bytes) { return bytes.size() == ContentHash{}.size(); }

bool same(const ContentHash& hash, const std::string& bytes) {
  return std::equal(hash.begin(), hash.end(), bytes.begin(), bytes.end(),
                    [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); });
}

Answer progress(std::size_t received) {
  v1::Result result = result_of(v1::RESULT_CODE_OK);
  result.mutable_asset()->set_received(static_cast<std::uint32_t>(received));
  return result;
}

Answer refusal_of_form(const v1::PutAsset& put) {
  if (!is_hash(put.hash())) {
    return result_of(v1::RESULT_CODE_INVALID, "put_asset.hash",
                     "Give the BLAKE2b-256 of the whole file, 32 bytes.");
  }
  if (put.size() == 0 || put.size() > kMaxSceneAssets) {
    return result_of(v1::RESULT_CODE_OUT_OF_RANGE, "put_asset.size",
                     "A file has 1 to 67108864 bytes. Make a coarser sphere-tree or mesh, or "
                     "install the file on the daemon's machine.");
  }
  return std::nullopt;
}

Answer out_of_order(std::size_t received) {
  return result_of(v1::RESULT_CODE_OUT_OF_RANGE, "put_asset.offset",
                   "The next piece begins at byte " + std::to_string(received) +
                       ". A file that is not whole is forgotten when another one begins or the "
                       "lease ends; ask without bytes how much there is.");
}

std::string path_of(int index, const char* field) {
  return "load_scene.assets[" + std::to_string(index) + "]" + field;
}

}  // namespace

AssetDesk::Kept* AssetDesk::known(const std::string& hash) noexcept {
  const auto found = std::find_if(kept_.begin(), kept_.end(),
                                  [&](const Kept& each) { return same(each.file->hash, hash); });
  if (found == kept_.end()) return nullptr;
  kept_.splice(kept_.end(), kept_, found);
  return &kept_.back();
}

Answer AssetDesk::put(const v1::PutAsset& put) {
  if (Answer refused = refusal_of_form(put)) return refused;
  Kept* kept = known(put.hash());
  if (kept != nullptr && kept->file->size != put.size()) {
    return result_of(v1::RESULT_CODE_INVALID, "put_asset.size",
                     "The file of this hash has " + std::to_string(kept->file->size) + " bytes.");
  }
  const std::size_t received = kept == nullptr ? 0 : kept->received;
  if (put.bytes().empty() || (kept != nullptr && kept->is_whole())) return progress(received);
  if (put.offset() != received) return out_of_order(received);
  const std::size_t length = std::min(kAssetPiece, put.size() - received);
  if (put.bytes().size() != length) {
    return result_of(v1::RESULT_CODE_INVALID, "put_asset.bytes",
                     "Pieces have 65536 bytes, but for the last one; this one has " +
                         std::to_string(length) + ".");
  }
  if (kept == nullptr) {
    if (Answer refused = begin(put)) return refused;
    kept = &kept_.back();
  }
  return take(put, *kept);
}

// Room is made for all of the file: what is kept never grows beyond it.
Answer AssetDesk::begin(const v1::PutAsset& put) {
  std::size_t used_bytes = 0;
  std::size_t used_files = 0;
  for (const Kept& each : kept_) {
    if (!each.is_used()) continue;
    used_bytes += each.file->size;
    ++used_files;
  }
  if (used_bytes + put.size() > kMaxKeptAssets || used_files >= kMaxKeptFiles) {
    return result_of(v1::RESULT_CODE_BUSY, "put_asset",
                     "Files of the scenes that play or are being loaded leave no room. Try again "
                     "once the scene before is gone, or load another one first.");
  }
  Kept next;
  next.file = std::make_shared<BroughtFile>();
  std::copy(put.hash().begin(), put.hash().end(), next.file->hash.begin());
  next.file->size = put.size();
  next.file->pieces.reserve((put.size() + kAssetPiece - 1) / kAssetPiece);
  static_cast<void>(crypto_generichash_init(&next.state, nullptr, 0, next.file->hash.size()));
  std::list<Kept> ready;
  ready.push_back(std::move(next));
  forget_unfinished();
  while (kept_bytes() + put.size() > kMaxKeptAssets || kept_.size() >= kMaxKeptFiles) {
    kept_.erase(
        std::find_if(kept_.begin(), kept_.end(), [](const Kept& each) { return !each.is_used(); }));
  }
  kept_.splice(kept_.end(), ready);
  return std::nullopt;
}

Answer AssetDesk::take(const v1::PutAsset& put, Kept& kept) {
  const std::string& piece = put.bytes();
  kept.file->pieces.push_back(piece);
  kept.received += piece.size();
  static_cast<void>(crypto_generichash_update(
      &kept.state, reinterpret_cast<const std::uint8_t*>(piece.data()), piece.size()));
  if (!kept.is_whole()) return progress(kept.received);
  ContentHash hash{};
  static_cast<void>(crypto_generichash_final(&kept.state, hash.data(), hash.size()));
  if (hash == kept.file->hash) return progress(kept.received);
  kept_.pop_back();
  return result_of(v1::RESULT_CODE_INVALID, "put_asset.hash",
                   "The bytes that came have another hash, and are forgotten. The file may have "
                   "changed meanwhile: read it again and send it anew.");
}

Answer AssetDesk::find(const v1::LoadScene& load, BroughtFiles& files) {
  if (load.assets_size() > 0 && !load.has_text()) {
    return result_of(v1::RESULT_CODE_INVALID, "load_scene.assets",
                     "An installed scene has installed files. Send the scene's text.");
  }
  if (load.assets_size() > kMaxNamedAssets) {
    return result_of(v1::RESULT_CODE_OUT_OF_RANGE, "load_scene.assets", "At most 256 files.");
  }
  std::size_t bytes = 0;
  for (int k = 0; k < load.assets_size(); ++k) {
    const v1::BroughtAsset& asset = load.assets(k);
    if (asset.name().empty() || asset.name().size() > kMaxName) {
      return result_of(v1::RESULT_CODE_INVALID, path_of(k, ".name"), "A name has 1 to 256 bytes.");
    }
    const Kept* kept = is_hash(asset.hash()) ? known(asset.hash()) : nullptr;
    if (kept == nullptr || !kept->is_whole()) {
      return result_of(v1::RESULT_CODE_NOT_FOUND, path_of(k, ".hash"),
                       "There is no file of this hash, or not any more. Bring it by PutAsset.");
    }
    bytes += kept->file->size;
    if (bytes > kMaxSceneAssets) {
      return result_of(v1::RESULT_CODE_OUT_OF_RANGE, "load_scene.assets",
                       "The files have more than 67108864 bytes together. Make coarser "
                       "sphere-trees or meshes, or install some on the daemon's machine.");
    }
    if (!files.emplace(asset.name(), kept->file).second) {
      return result_of(v1::RESULT_CODE_INVALID, path_of(k, ".name"), "It has a file already.");
    }
  }
  return std::nullopt;
}

void AssetDesk::forget_unfinished() noexcept {
  kept_.remove_if([](const Kept& each) { return !each.is_whole(); });
}

std::size_t AssetDesk::kept_bytes() const noexcept {
  std::size_t bytes = 0;
  for (const Kept& each : kept_) bytes += each.file->size;
  return bytes;
}

}  // namespace hapticd

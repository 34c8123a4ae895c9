// Files of scenes that clients bring: taken piece by piece under the lease, proven by their hash,
// and kept in memory until others need the room. No file of the machine is touched. What is kept is
// bounded, whoever asks for what. Not RT.
#pragma once

#include <sodium.h>

#include <cstdint>
#include <list>
#include <memory>
#include <string>

#include "core/tree/measured_tree.h"
#include "server/daemon/served_clients.h"
#include "server/scene_io/brought_file.h"

namespace hapticd {

/// Length of a piece, bytes, but for a file's last one. More: the network thread hashes for longer
/// at a time, 65 us now.
inline constexpr std::size_t kAssetPiece = 65'536;
/// Largest file, and most that the files of one scene have together, bytes.
inline constexpr std::size_t kMaxSceneAssets = std::size_t{64} << 20U;
/// Most that is kept, bytes: the files of the scene that plays and those of the next one.
inline constexpr std::size_t kMaxKeptAssets = 2 * kMaxSceneAssets;
/// Files that one LoadScene names, and files that are kept.
inline constexpr int kMaxNamedAssets = 256;
inline constexpr std::size_t kMaxKeptFiles = std::size_t{2} * kMaxNamedAssets;

class AssetDesk {
 public:
  /// PutAsset: takes a piece, or says how much there is. Some 100 us for a piece. Throws
  /// std::bad_alloc, and has what it had.
  [[nodiscard]] Answer put(const v1::PutAsset& put);
  /// The files that `load` names, into `files`; why it is refused, else nothing. Throws
  /// std::bad_alloc.
  [[nodiscard]] Answer find(const v1::LoadScene& load, BroughtFiles& files);
  /// The lease is over: a file that is not whole is forgotten.
  void forget_unfinished() noexcept;
  /// Bytes kept, those still to come of the file on its way included: at most kMaxKeptAssets.
  [[nodiscard]] std::size_t kept_bytes() const noexcept;

 private:
  /// A file, and its hash as far as it has come.
  struct Kept {
    std::shared_ptr<BroughtFile> file;
    std::size_t received = 0;
    crypto_generichash_state state{};

    [[nodiscard]] bool is_whole() const noexcept { return received == file->size; }
    /// A scene that plays, or is being built, has it.
    [[nodiscard]] bool is_used() const noexcept { return file.use_count() > 1; }
  };

  [[nodiscard]] Kept* known(const std::string& hash) noexcept;
  [[nodiscard]] Answer begin(const v1::PutAsset& put);
  [[nodiscard]] Answer take(const v1::PutAsset& put, Kept& kept);

  std::list<Kept> kept_;  ///< longest unused first; one at most is not whole
};

}  // namespace hapticd

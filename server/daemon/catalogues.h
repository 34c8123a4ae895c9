// What the List requests answer, kept from one to the next: any session may ask at any time, and a
// Stop must not wait for files that have been read before. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace hapticd {

/// Names in a list (Listing.names).
inline constexpr std::size_t kMaxListed = 4096;

/// A name that may be asked for.
struct ListedName {
  std::string name;
  std::string description;  ///< its first line, 400 bytes at most; may be empty
};

/// What tells that a file has changed.
struct FileIdentity {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::uint64_t bytes = 0;
  std::int64_t modified_ns = 0;  ///< since 1970
  std::int64_t changed_ns = 0;   ///< since 1970; nobody can set it

  friend bool operator==(const FileIdentity&, const FileIdentity&) = default;
};

/// Where the lists come from; a test counts what is read.
struct CatalogueSources {
  std::vector<std::filesystem::path> scenes;
  std::vector<std::filesystem::path> gestures;
  std::filesystem::path recordings;
  /// Read a file; empty where it describes nothing.
  std::function<std::string(const std::filesystem::path&)> describe_scene;
  std::function<std::string(const std::filesystem::path&)> describe_gesture;
  std::function<std::int64_t()> now_ns;  ///< since 1970
};

/// The folders of the installation, the folder of recordings, the system's clock.
[[nodiscard]] CatalogueSources installed_catalogues();

/// Lists of names. A folder is read again when something in it was added, removed or renamed, the
/// file of a scene or a gesture when it has changed, the folder of recordings, which are ordered by
/// age, every second. What is returned is valid until the next call.
class Catalogues {
 public:
  explicit Catalogues(CatalogueSources sources = installed_catalogues());

  /// In alphabetical order.
  [[nodiscard]] const std::vector<ListedName>& scenes();
  [[nodiscard]] const std::vector<ListedName>& gestures();
  /// Oldest first, without descriptions; the newest where there are too many.
  [[nodiscard]] const std::vector<ListedName>& recordings();

 private:
  /// A file as it was read.
  struct Described {
    FileIdentity file;
    bool settled = false;  ///< a further change would be noticed
    std::string description;
  };
  /// A list and the folders it was read from.
  struct Kept {
    std::vector<ListedName> names;
    std::vector<FileIdentity> folders;
    std::map<std::filesystem::path, Described> described;
    std::int64_t read_ns = 0;
    bool read = false;
  };

  /// Whether `kept` is to be read again; if so, it is taken to be read now.
  bool is_stale(Kept& kept, const std::vector<std::filesystem::path>& folders) const;
  [[nodiscard]] bool is_settled(const FileIdentity& file) const;
  /// Describes the names of `kept` by their files in its folders, those that have changed anew.
  void describe(Kept& kept, const std::vector<std::filesystem::path>& folders,
                const std::function<std::string(const std::filesystem::path&)>& read);

  CatalogueSources sources_;
  Kept scenes_;
  Kept gestures_;
  Kept recordings_;
};

}  // namespace hapticd

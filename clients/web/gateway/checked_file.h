// Files that are streamed to browsers in blocks: nothing of them is mapped or kept, so that a file
// that is cut off, replaced or written to meanwhile harms nobody, and each block is compared with
// what the file was when it was read whole, so that no reader gets a mixture. Not RT.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hapticd::web {

/// Longest file that is served, bytes.
inline constexpr std::uint64_t kMaxFileBytes = 64U << 20U;
/// What is read, compared and sent at once, bytes: all of a file that a reader makes us hold.
inline constexpr std::size_t kBlockBytes = 64U << 10U;

/// BLAKE2b-256 of `bytes` in hexadecimal, as in an address of the gateway.
[[nodiscard]] std::string hash_of(std::string_view bytes);

/// What tells that a file was changed or replaced without reading it.
struct FileStamp {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::uint64_t size = 0;  ///< bytes
  std::int64_t modified_ns = 0;
  std::int64_t changed_ns = 0;

  bool operator==(const FileStamp&) const = default;
};

/// What a file held when it was read whole.
struct FileDigest {
  std::string hash;  ///< as hash_of()
  std::uint64_t size = 0;
  std::vector<std::array<std::uint8_t, 16>> blocks;  ///< BLAKE2b-128 of each
};

/// A file that is open for reading.
class OpenFile {
 public:
  /// Nothing when it cannot be opened, is a link or no plain file, or is longer than kMaxFileBytes.
  [[nodiscard]] static std::optional<OpenFile> at(const std::filesystem::path& path);
  ~OpenFile();
  OpenFile(OpenFile&& other) noexcept;
  OpenFile& operator=(OpenFile&&) = delete;
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  /// Of the moment it was opened.
  [[nodiscard]] const FileStamp& stamp() const noexcept { return stamp_; }
  /// Up to kBlockBytes from there; fewer at its end, none where it cannot be read.
  [[nodiscard]] std::string read(std::uint64_t offset) const;
  /// Reads it whole, block by block; nothing where it turned out longer than kMaxFileBytes.
  [[nodiscard]] std::optional<FileDigest> digest() const;

 private:
  OpenFile(int descriptor, const FileStamp& stamp) noexcept
      : descriptor_(descriptor), stamp_(stamp) {}

  int descriptor_;
  FileStamp stamp_;
};

/// A file that is what it was.
class CheckedFile {
 public:
  CheckedFile(OpenFile file, std::shared_ptr<const FileDigest> digest)
      : file_(std::move(file)), digest_(std::move(digest)) {}

  [[nodiscard]] const std::string& hash() const noexcept { return digest_->hash; }
  [[nodiscard]] std::uint64_t size() const noexcept { return digest_->size; }
  [[nodiscard]] std::size_t blocks() const noexcept { return digest_->blocks.size(); }
  /// Block `index`, below blocks(); nothing where the file has changed in it.
  [[nodiscard]] std::optional<std::string> block(std::size_t index) const;

 private:
  OpenFile file_;
  std::shared_ptr<const FileDigest> digest_;
};

}  // namespace hapticd::web

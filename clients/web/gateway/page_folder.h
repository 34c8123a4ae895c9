// The files of the page: those below one folder, by the path of an address, and packed where the
// build left a packed one beside them. Not RT.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "clients/web/gateway/checked_file.h"

namespace hapticd::web {

/// A file to be sent.
struct PageFile {
  std::string type;       ///< of its content, for the browser
  bool gzip = false;      ///< it is packed
  bool has_gzip = false;  ///< it may be had packed: what is sent depends on what is accepted
  bool lasting = false;   ///< its name changes with its content, so it may be kept for ever
  std::shared_ptr<const CheckedFile> file;
};

class PageFolder {
 public:
  explicit PageFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// The file at `target` (the path of a request, / and all); / is index.html. Where `gzip` is
  /// accepted and NAME.gz is there and not older than NAME, it is that. Nothing when there is none,
  /// or the path leads out of the folder, or to a name that begins with a dot.
  [[nodiscard]] std::optional<PageFile> find(std::string_view target, bool gzip);

 private:
  struct Seen {
    FileStamp stamp;
    std::shared_ptr<const FileDigest> digest;
  };

  [[nodiscard]] std::optional<std::filesystem::path> real(const std::filesystem::path& file) const;
  [[nodiscard]] std::shared_ptr<const CheckedFile> open(const std::filesystem::path& real);

  std::filesystem::path folder_;
  std::map<std::filesystem::path, Seen> seen_;
};

/// Type of content by the end of a name.
[[nodiscard]] std::string content_type(const std::filesystem::path& name);

/// Whether an Accept-Encoding allows gzip.
[[nodiscard]] bool accepts_gzip(std::string_view accept_encoding);

}  // namespace hapticd::web

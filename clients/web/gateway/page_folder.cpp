// See page_folder.h.
#include "clients/web/gateway/page_folder.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <system_error>
#include <utility>

namespace hapticd::web {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::pair<std::string_view, std::string_view>, 13> kTypes{{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".mjs", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".map", "application/json"},
    {".webmanifest", "application/manifest+json"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".jpg", "image/jpeg"},
    {".ico", "image/x-icon"},
    {".woff2", "font/woff2"},
    {".wasm", "application/wasm"},
}};

/// Only names as a bundler makes them: nothing to decode, nothing that climbs.
bool is_plain(std::string_view path) {
  constexpr std::string_view kLetters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./";
  return path.find_first_not_of(kLetters) == std::string_view::npos &&
         path.find("/.") == std::string_view::npos && path.find("//") == std::string_view::npos;
}

}  // namespace

std::string content_type(const fs::path& name) {
  const std::string end = name.extension().string();
  for (const auto& [known, type] : kTypes) {
    if (end == known) return std::string(type);
  }
  return "application/octet-stream";
}

bool accepts_gzip(std::string_view accept_encoding) {
  while (!accept_encoding.empty()) {
    const std::size_t comma = accept_encoding.find(',');
    std::string one(accept_encoding.substr(0, comma));
    accept_encoding =
        comma == std::string_view::npos ? std::string_view{} : accept_encoding.substr(comma + 1);
    std::erase_if(one, [](char letter) { return letter == ' ' || letter == '\t'; });
    std::transform(one.begin(), one.end(), one.begin(),
                   [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
    const std::string name = one.substr(0, one.find(';'));
    if (name != "gzip" && name != "x-gzip") continue;
    // A weight of zero, q=0 with as many zeros as one likes, is a no.
    const std::size_t weight = one.find(";q=");
    return weight == std::string::npos ||
           one.find_first_not_of("0.", weight + 3) != std::string::npos;
  }
  return false;
}

std::optional<fs::path> PageFolder::real(const fs::path& file) const {
  // A link inside of the folder may lead out of it.
  std::error_code unknown;
  const fs::path root = fs::canonical(folder_, unknown);
  fs::path found = fs::canonical(file, unknown);
  if (unknown || !fs::is_regular_file(found, unknown)) return std::nullopt;
  const fs::path below = found.lexically_relative(root);
  if (below.empty() || *below.begin() == "..") return std::nullopt;
  return found;
}

std::shared_ptr<const CheckedFile> PageFolder::open(const fs::path& real) {
  auto file = OpenFile::at(real);
  if (!file.has_value()) return nullptr;
  Seen& known = seen_[real];
  if (known.digest == nullptr || known.stamp != file->stamp()) {
    auto digest = file->digest();
    if (!digest.has_value()) return nullptr;
    known = {file->stamp(), std::make_shared<const FileDigest>(std::move(*digest))};
  }
  return std::make_shared<const CheckedFile>(std::move(*file), known.digest);
}

std::optional<PageFile> PageFolder::find(std::string_view target, bool gzip) {
  const std::string_view path = target.substr(0, target.find_first_of("?#"));
  if (!path.starts_with('/') || !is_plain(path)) return std::nullopt;
  fs::path file = folder_ / path.substr(1);
  if (path.ends_with('/')) file /= "index.html";
  const auto plain = real(file);
  if (!plain.has_value()) return std::nullopt;
  PageFile found;
  found.type = content_type(file);
  found.lasting = path.starts_with("/assets/");
  const auto packed = real(fs::path(file) += ".gz");
  std::error_code unknown;
  // An older one is of what the file was before somebody changed it.
  found.has_gzip = packed.has_value() &&
                   fs::last_write_time(*packed, unknown) >= fs::last_write_time(*plain, unknown);
  found.gzip = gzip && found.has_gzip;
  found.file = open(found.gzip ? *packed : *plain);
  if (found.file == nullptr) return std::nullopt;
  return found;
}

}  // namespace hapticd::web

// See page_folder.h.
#include "clients/web/gateway/page_folder.h"

#include <array>
#include <system_error>
#include <utility>

#include "clients/web/gateway/asset_store.h"

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

std::optional<PageFile> page_file(const fs::path& folder, std::string_view target) {
  const std::string_view path = target.substr(0, target.find_first_of("?#"));
  if (!path.starts_with('/') || !is_plain(path)) return std::nullopt;
  fs::path file = folder / path.substr(1);
  if (path.ends_with('/')) file /= "index.html";
  // A link inside of the folder may lead out of it.
  std::error_code unknown;
  const fs::path root = fs::canonical(folder, unknown);
  const fs::path real = fs::canonical(file, unknown);
  if (unknown || !fs::is_regular_file(real, unknown)) return std::nullopt;
  const fs::path below = real.lexically_relative(root);
  if (below.empty() || *below.begin() == "..") return std::nullopt;
  auto bytes = read_whole(real);
  if (!bytes.has_value()) return std::nullopt;
  return PageFile{content_type(file), std::move(*bytes), path.starts_with("/assets/")};
}

}  // namespace hapticd::web

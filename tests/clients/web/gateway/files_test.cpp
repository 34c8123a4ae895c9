// What is served from folders. The hashes are those that the published program b2sum gives
// (`printf abc | b2sum -l 256`).
#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <random>

#include "clients/web/gateway/asset_store.h"
#include "clients/web/gateway/page_folder.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHashOfAbc =
    "bddd813c634239723171ef3fee98579b94964e3bb1cb3e427262c8c068d52319";

/// A folder of its own that goes with it.
struct Folder {
  Folder() {
    std::string name = (fs::temp_directory_path() / "hapticd_web_XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    path = name;
  }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  void write(const std::string& name, const std::string& bytes) const {
    fs::create_directories((path / name).parent_path());
    std::ofstream(path / name, std::ios::binary) << bytes;
  }
  fs::path path;
};

/// All that is read of it, block after block; nothing where there is none, or it has changed.
std::optional<std::string> content(const std::shared_ptr<const web::CheckedFile>& file) {
  if (file == nullptr) return std::nullopt;
  std::string all;
  for (std::size_t i = 0; i < file->blocks(); ++i) {
    const auto block = file->block(i);
    if (!block.has_value()) return std::nullopt;
    all += *block;
  }
  CHECK(all.size() == file->size());
  return all;
}

TEST_CASE("a file is found by what is in it, in whichever folder it is") {
  const Folder one;
  const Folder other;
  other.write("deep/body.ply", "abc");
  web::AssetStore store({one.path, other.path});
  CHECK(content(store.find(kHashOfAbc, 1)) == "abc");
  CHECK(store.find(std::string(64, '0'), 1) == nullptr);
  CHECK(store.find("../deep/body.ply", 1) == nullptr);
}

TEST_CASE("a file that came later is found, one that changed is not given for what it was") {
  const Folder folder;
  web::AssetStore store({folder.path});
  CHECK(store.find(kHashOfAbc, 10) == nullptr);
  folder.write("late.tree", "abc");
  CHECK(content(store.find(kHashOfAbc, 2'000'000'000)) == "abc");
  folder.write("late.tree", "abd");
  CHECK(content(store.find(kHashOfAbc, 2'000'000'001)) == std::nullopt);
}

TEST_CASE("of two files with the same content one may go") {
  const Folder folder;
  folder.write("one.ply", "abc");
  folder.write("two.ply", "abc");
  web::AssetStore store({folder.path});
  const auto held = store.find(kHashOfAbc, 1);
  fs::remove(folder.path / "two.ply");
  static_cast<void>(store.find(kHashOfAbc, 2'000'000'000));
  CHECK(content(store.find(kHashOfAbc, 4'000'000'000)) == "abc");
  fs::remove(folder.path / "one.ply");
  CHECK(store.find(kHashOfAbc, 6'000'000'000) == nullptr);
  // Who has begun to read it reads on.
  CHECK(content(held) == "abc");
}

TEST_CASE(
    "no reader gets a mixture: blocks of a file that was written to, or cut off, are refused") {
  const Folder folder;
  const std::uint64_t seed = std::random_device{}();
  CAPTURE(seed);
  SplitMix64 random(seed);
  std::string bytes(web::kBlockBytes * 2 + 1 + random.below(1000), '\0');
  for (char& byte : bytes) byte = static_cast<char>(random.next());
  folder.write("body.ply", bytes);
  web::AssetStore store({folder.path});
  const auto file = store.find(web::hash_of(bytes), 1);
  REQUIRE(content(file) == bytes);
  REQUIRE(file->blocks() == 3);
  // In place, so that the time of its change may stay the same.
  std::fstream stream(folder.path / "body.ply", std::ios::in | std::ios::out | std::ios::binary);
  const std::size_t place = web::kBlockBytes + random.below(web::kBlockBytes);
  stream.seekp(static_cast<std::streamoff>(place));
  stream.put(static_cast<char>(bytes[place] + 1));
  stream.close();
  CHECK(file->block(0) == bytes.substr(0, web::kBlockBytes));
  CHECK(file->block(1) == std::nullopt);
  CHECK(file->block(2) == bytes.substr(2 * web::kBlockBytes));
  fs::resize_file(folder.path / "body.ply", 10);
  for (std::size_t i = 0; i < 3; ++i) CHECK(file->block(i) == std::nullopt);
}

TEST_CASE("what is no plain file, or longer than any model, is not read") {
  const Folder folder;
  folder.write("site/index.html", "<html>");
  REQUIRE(::mkfifo((folder.path / "site" / "pipe.html").c_str(), 0600) == 0);
  std::ofstream(folder.path / "site" / "long.html") << "x";
  fs::resize_file(folder.path / "site" / "long.html", web::kMaxFileBytes + 1);
  web::PageFolder site(folder.path / "site");
  CHECK_FALSE(site.find("/pipe.html", false).has_value());
  CHECK_FALSE(site.find("/long.html", false).has_value());
  CHECK_FALSE(web::OpenFile::at(folder.path / "site" / "pipe.html").has_value());
  CHECK_FALSE(web::OpenFile::at(folder.path / "site").has_value());
}

TEST_CASE("links are not followed out of a folder of assets") {
  const Folder folder;
  const Folder elsewhere;
  elsewhere.write("secret", "abc");
  fs::create_symlink(elsewhere.path / "secret", folder.path / "link.ply");
  fs::create_directory_symlink(elsewhere.path, folder.path / "more");
  web::AssetStore store({folder.path});
  CHECK(store.find(kHashOfAbc, 5'000'000'000) == nullptr);
}

TEST_CASE("the page's files are found by their path, with their type") {
  const Folder folder;
  folder.write("index.html", "<html>");
  folder.write("assets/app-1a2b.js", "go()");
  web::PageFolder page(folder.path);
  const auto index = page.find("/", false);
  REQUIRE(index.has_value());
  CHECK(content(index->file) == "<html>");
  CHECK(index->type == "text/html; charset=utf-8");
  CHECK_FALSE(index->lasting);
  const auto script = page.find("/assets/app-1a2b.js?x=1", false);
  REQUIRE(script.has_value());
  CHECK(script->type == "text/javascript; charset=utf-8");
  CHECK(script->lasting);
  // One that is changed is sent as it is now.
  folder.write("index.html", "<html lang=en>");
  CHECK(content(page.find("/", false)->file) == "<html lang=en>");
}

TEST_CASE("who accepts gzip gets what was packed, unless the text is newer than that") {
  const Folder folder;
  folder.write("index.html", "<html>");
  folder.write("index.html.gz", "packed");
  web::PageFolder page(folder.path);
  const auto packed = page.find("/", true);
  REQUIRE(packed.has_value());
  CHECK(packed->gzip);
  CHECK(packed->type == "text/html; charset=utf-8");
  CHECK(content(packed->file) == "packed");
  const auto plain = page.find("/", false);
  REQUIRE(plain.has_value());
  CHECK_FALSE(plain->gzip);
  CHECK(plain->has_gzip);
  CHECK(content(plain->file) == "<html>");
  CHECK(plain->file->hash() != packed->file->hash());
  const auto written = fs::last_write_time(folder.path / "index.html.gz");
  fs::last_write_time(folder.path / "index.html", written + std::chrono::seconds(1));
  CHECK(content(page.find("/", true)->file) == "<html>");
}

TEST_CASE("gzip is accepted by its name, unless with a weight of zero") {
  for (const char* yes : {"gzip", "br, gzip", "deflate , GZIP;q=0.5", "gzip;q=1.000", "x-gzip"}) {
    CAPTURE(yes);
    CHECK(web::accepts_gzip(yes));
  }
  for (const char* no : {"", "br", "gzip;q=0", "gzip; q=0.000, br", "gzipped", "identity", "*"}) {
    CAPTURE(no);
    CHECK_FALSE(web::accepts_gzip(no));
  }
}

TEST_CASE("no path leads out of the page's folder, nor to hidden files") {
  const Folder folder;
  folder.write("site/index.html", "<html>");
  folder.write("site/.env", "secret");
  folder.write("secret", "secret");
  folder.write("secret.gz", "secret");
  fs::create_symlink(folder.path / "secret", folder.path / "site" / "link");
  fs::create_symlink(folder.path / "secret", folder.path / "site" / "index.html.gz");
  web::PageFolder site(folder.path / "site");
  for (const char* target :
       {"/../secret", "/%2e%2e/secret", "/link", "/.env", "//secret", "secret",
        "/site/../../secret", "/a b", "/nothing", "", "/..", "/assets/../.env", "/..%2fsecret",
        "/%00", "/index.html/", "/index.html/../../secret", "/\\..\\secret"}) {
    CAPTURE(target);
    CHECK_FALSE(site.find(target, false).has_value());
    CHECK_FALSE(site.find(target, true).has_value());
  }
  CHECK_FALSE(site.find("/", true)->gzip);
}

}  // namespace
}  // namespace hapticd::test

// Files that peers bring: whole ones are those of their hash, whatever comes in between, and what
// is kept stays within its bounds. Judged by the bytes that were sent and by libsodium in one go.
#include "server/daemon/asset_desk.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>

#include "server/scene_io/sphere_tree_file.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

std::string hash_of(const std::string& bytes) {
  const ContentHash hash =
      content_hash({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  return {hash.begin(), hash.end()};
}

std::string random_bytes(std::size_t size, SplitMix64& random) {
  std::string bytes(size, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random.next());
  return bytes;
}

v1::PutAsset piece_of(const std::string& bytes, std::size_t offset) {
  v1::PutAsset put;
  put.set_hash(hash_of(bytes));
  put.set_size(static_cast<std::uint32_t>(bytes.size()));
  put.set_offset(static_cast<std::uint32_t>(offset));
  if (offset < bytes.size()) put.set_bytes(bytes.substr(offset, kAssetPiece));
  return put;
}

v1::PutAsset question(const std::string& bytes) {
  v1::PutAsset put = piece_of(bytes, 0);
  put.clear_bytes();
  return put;
}

std::size_t there(AssetDesk& desk, const std::string& bytes) {
  const Answer answer = desk.put(question(bytes));
  REQUIRE(answer.has_value());
  REQUIRE(answer->code() == v1::RESULT_CODE_OK);
  return answer->asset().received();
}

/// The code of the last answer.
v1::ResultCode bring(AssetDesk& desk, const std::string& bytes) {
  v1::PutAsset put = question(bytes);
  Answer answer;
  for (std::size_t offset = 0; offset < bytes.size(); offset += kAssetPiece) {
    put.set_offset(static_cast<std::uint32_t>(offset));
    put.set_bytes(bytes.substr(offset, kAssetPiece));
    answer = desk.put(put);
    if (answer->code() != v1::RESULT_CODE_OK) break;
  }
  return answer->code();
}

v1::LoadScene naming(const std::vector<std::string>& hashes) {
  v1::LoadScene load;
  load.set_text("name: \"x\"");
  for (const std::string& hash : hashes) {
    v1::BroughtAsset& asset = *load.add_assets();
    asset.set_name("file_" + std::to_string(load.assets_size()));
    asset.set_hash(hash);
  }
  return load;
}

/// A file of so many bytes, unlike those of other numbers.
std::string numbered(std::uint64_t number, std::size_t size) {
  std::string bytes(size, 'x');
  bytes.replace(0, 8, std::string(reinterpret_cast<const char*>(&number), 8));
  return bytes;
}

void check_refusal(const Answer& answer, v1::ResultCode code, const std::string& path) {
  REQUIRE(answer.has_value());
  CHECK(answer->code() == code);
  CHECK(answer->path() == path);
  CHECK_FALSE(answer->message().empty());
  CHECK(answer->message().size() <= 400);
}

}  // namespace

TEST_CASE("a file of any size comes in pieces and is found by its hash, byte for byte") {
  SplitMix64 random(11);
  AssetDesk desk;
  for (const std::size_t size :
       {std::size_t{1}, kAssetPiece - 1, kAssetPiece, kAssetPiece + 1, 3 * kAssetPiece,
        static_cast<std::size_t>(1 + random.below(10 * kAssetPiece))}) {
    CAPTURE(size);
    const std::string bytes = random_bytes(size, random);
    CHECK(there(desk, bytes) == 0);
    for (std::size_t offset = 0; offset < size; offset += kAssetPiece) {
      CHECK(there(desk, bytes) == offset);
      BroughtFiles none;
      check_refusal(desk.find(naming({hash_of(bytes)}), none), v1::RESULT_CODE_NOT_FOUND,
                    "load_scene.assets[0].hash");
      REQUIRE(desk.put(piece_of(bytes, offset))->code() == v1::RESULT_CODE_OK);
    }
    CHECK(there(desk, bytes) == size);
    BroughtFiles files;
    CHECK_FALSE(desk.find(naming({hash_of(bytes)}), files).has_value());
    const std::vector<std::uint8_t> found = files.at("file_1")->bytes();
    CHECK(std::string(found.begin(), found.end()) == bytes);
  }
}

TEST_CASE("what is not as it was said is refused with a remedy, and changes nothing") {
  SplitMix64 random(12);
  AssetDesk desk;
  const std::string bytes = random_bytes(2 * kAssetPiece + 5, random);
  REQUIRE(desk.put(piece_of(bytes, 0))->code() == v1::RESULT_CODE_OK);
  v1::PutAsset put = piece_of(bytes, kAssetPiece);
  const auto refuse = [&](v1::ResultCode code, const std::string& path) {
    check_refusal(desk.put(put), code, path);
    CHECK(there(desk, bytes) == kAssetPiece);
    put = piece_of(bytes, kAssetPiece);
  };
  put.set_offset(2 * kAssetPiece);
  refuse(v1::RESULT_CODE_OUT_OF_RANGE, "put_asset.offset");
  put.set_offset(0);
  refuse(v1::RESULT_CODE_OUT_OF_RANGE, "put_asset.offset");
  put.mutable_bytes()->pop_back();
  refuse(v1::RESULT_CODE_INVALID, "put_asset.bytes");
  put.mutable_bytes()->append("x");
  put.mutable_bytes()->append("x");
  refuse(v1::RESULT_CODE_INVALID, "put_asset.bytes");
  put.mutable_hash()->pop_back();
  refuse(v1::RESULT_CODE_INVALID, "put_asset.hash");
  put.set_size(put.size() + 1);
  refuse(v1::RESULT_CODE_INVALID, "put_asset.size");
  put.set_size(0);
  refuse(v1::RESULT_CODE_OUT_OF_RANGE, "put_asset.size");
  put.set_size(static_cast<std::uint32_t>(kMaxSceneAssets + 1));
  refuse(v1::RESULT_CODE_OUT_OF_RANGE, "put_asset.size");
}

TEST_CASE("bytes of another hash are forgotten, and can be sent again") {
  SplitMix64 random(13);
  AssetDesk desk;
  std::string bytes = random_bytes(kAssetPiece + 100, random);
  v1::PutAsset last = piece_of(bytes, kAssetPiece);
  REQUIRE(desk.put(piece_of(bytes, 0))->code() == v1::RESULT_CODE_OK);
  last.mutable_bytes()->back() ^= 1;
  check_refusal(desk.put(last), v1::RESULT_CODE_INVALID, "put_asset.hash");
  CHECK(there(desk, bytes) == 0);
  CHECK(desk.kept_bytes() == 0);
  CHECK(bring(desk, bytes) == v1::RESULT_CODE_OK);
}

TEST_CASE("a file on its way is forgotten when another one begins or the lease ends") {
  SplitMix64 random(14);
  AssetDesk desk;
  const std::string first = random_bytes(3 * kAssetPiece, random);
  const std::string second = random_bytes(3 * kAssetPiece, random);
  REQUIRE(desk.put(piece_of(first, 0))->code() == v1::RESULT_CODE_OK);
  REQUIRE(desk.put(piece_of(second, 0))->code() == v1::RESULT_CODE_OK);
  CHECK(there(desk, first) == 0);
  CHECK(there(desk, second) == kAssetPiece);
  CHECK(desk.kept_bytes() == second.size());
  desk.forget_unfinished();
  CHECK(there(desk, second) == 0);
  CHECK(desk.kept_bytes() == 0);
  CHECK(bring(desk, first) == v1::RESULT_CODE_OK);
  desk.forget_unfinished();
  CHECK(there(desk, first) == first.size());
}

TEST_CASE("what was named longest ago makes room, but nothing that a scene uses") {
  AssetDesk desk;
  constexpr std::size_t kLarge = kMaxKeptAssets / 4;
  std::vector<std::string> files;
  for (std::uint64_t k = 0; k < 4; ++k) {
    files.push_back(numbered(k, kLarge));
    REQUIRE(bring(desk, files.back()) == v1::RESULT_CODE_OK);
  }
  CHECK(desk.kept_bytes() == kMaxKeptAssets);
  BroughtFiles used;
  CHECK_FALSE(desk.find(naming({hash_of(files[0])}), used).has_value());
  CHECK(there(desk, files[1]) == kLarge);
  CHECK(bring(desk, numbered(4, kLarge)) == v1::RESULT_CODE_OK);
  CHECK(there(desk, files[2]) == 0);
  for (const int kept : {0, 1, 3}) CHECK(there(desk, files[static_cast<std::size_t>(kept)]) > 0);
  CHECK(bring(desk, numbered(5, kMaxSceneAssets)) == v1::RESULT_CODE_OK);
  CHECK(there(desk, files[0]) == kLarge);
  CHECK(desk.kept_bytes() <= kMaxKeptAssets);
  CHECK(desk.find(naming({hash_of(numbered(5, kMaxSceneAssets))}), used)->code() ==
        v1::RESULT_CODE_INVALID);  // file_1 is taken
  BroughtFiles other;
  CHECK_FALSE(desk.find(naming({hash_of(numbered(5, kMaxSceneAssets))}), other).has_value());
  check_refusal(desk.put(piece_of(numbered(6, kMaxSceneAssets), 0)), v1::RESULT_CODE_BUSY,
                "put_asset");
  other.clear();
  CHECK(desk.put(piece_of(numbered(6, kMaxSceneAssets), 0))->code() == v1::RESULT_CODE_OK);
  CHECK(desk.kept_bytes() <= kMaxKeptAssets);
}

TEST_CASE("however small files are, only so many are kept") {
  AssetDesk desk;
  const std::uint64_t count = kMaxKeptFiles + 20;
  for (std::uint64_t k = 0; k < count; ++k)
    REQUIRE(bring(desk, numbered(k, 8)) == v1::RESULT_CODE_OK);
  CHECK(desk.kept_bytes() == 8 * kMaxKeptFiles);
  CHECK(there(desk, numbered(19, 8)) == 0);
  CHECK(there(desk, numbered(20, 8)) == 8);
}

TEST_CASE("a LoadScene names only so much, each name once, and text alone has files") {
  AssetDesk desk;
  const std::string small = numbered(1, 100);
  const std::string large = numbered(2, kMaxSceneAssets - 100);
  REQUIRE(bring(desk, small) == v1::RESULT_CODE_OK);
  REQUIRE(bring(desk, large) == v1::RESULT_CODE_OK);
  BroughtFiles files;
  CHECK_FALSE(desk.find(naming({hash_of(small), hash_of(large)}), files).has_value());
  CHECK(files.size() == 2);
  files.clear();
  check_refusal(desk.find(naming({hash_of(large), hash_of(small), hash_of(small)}), files),
                v1::RESULT_CODE_OUT_OF_RANGE, "load_scene.assets");
  check_refusal(desk.find(naming(std::vector<std::string>(257, hash_of(small))), files),
                v1::RESULT_CODE_OUT_OF_RANGE, "load_scene.assets");
  check_refusal(desk.find(naming({hash_of(small).substr(1)}), files), v1::RESULT_CODE_NOT_FOUND,
                "load_scene.assets[0].hash");
  files.clear();
  v1::LoadScene load = naming({hash_of(small), hash_of(small)});
  load.mutable_assets(1)->set_name("file_1");
  check_refusal(desk.find(load, files), v1::RESULT_CODE_INVALID, "load_scene.assets[1].name");
  for (const std::string& name : {std::string(), std::string(257, 'a')}) {
    files.clear();
    load.mutable_assets(1)->set_name(name);
    check_refusal(desk.find(load, files), v1::RESULT_CODE_INVALID, "load_scene.assets[1].name");
  }
  load.set_name("installed");
  check_refusal(desk.find(load, files), v1::RESULT_CODE_INVALID, "load_scene.assets");
}

TEST_CASE(
    "whatever a random peer sends, what is found has its hash and no more is kept than may be") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  AssetDesk desk;
  std::vector<std::string> files;
  const auto new_file = [&] { return random_bytes(1 + random.below(3 * kAssetPiece), random); };
  files.resize(3);
  std::generate(files.begin(), files.end(), new_file);
  std::map<std::string, BroughtFiles> scenes;
  int found = 0;
  const std::int64_t count = scaled(30'000);
  for (std::int64_t i = 0; i < count; ++i) {
    std::string& bytes = files[random.below(files.size())];
    if (random.chance(0.1)) bytes = new_file();
    v1::PutAsset put = piece_of(bytes, kAssetPiece * random.below(5));
    if (random.chance(0.6)) put = piece_of(bytes, desk.put(question(bytes))->asset().received());
    if (random.chance(0.05)) put.set_size(static_cast<std::uint32_t>(random.next()));
    if (random.chance(0.05)) put.set_offset(static_cast<std::uint32_t>(random.next()));
    if (random.chance(0.05)) put.set_hash(random_bytes(random.below(40), random));
    if (random.chance(0.05)) put.set_bytes(random_bytes(random.below(2 * kAssetPiece), random));
    if (random.chance(0.05)) {
      put.set_hash(random_bytes(32, random));
      put.set_size(static_cast<std::uint32_t>(1 + random.below(kMaxSceneAssets)));
    }
    if (!put.bytes().empty() && random.chance(0.05)) put.mutable_bytes()->back() ^= 1;
    const Answer answer = desk.put(put);
    REQUIRE(answer.has_value());
    CHECK((answer->code() == v1::RESULT_CODE_OK || !answer->message().empty()));
    CHECK(desk.kept_bytes() <= kMaxKeptAssets);
    if (random.chance(0.01)) desk.forget_unfinished();
    BroughtFiles brought;
    if (desk.find(naming({hash_of(bytes)}), brought).has_value()) continue;
    ++found;
    const std::vector<std::uint8_t> all = brought.at("file_1")->bytes();
    REQUIRE(std::string(all.begin(), all.end()) == bytes);
    scenes[random.chance(0.5) ? "plays" : "next"] = std::move(brought);
  }
  CHECK(found > 0);
}

}  // namespace hapticd::test

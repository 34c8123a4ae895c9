// Truth: what was written; published CRCs; and every way a file can end or be damaged.
#include <doctest/doctest.h>

#include <fstream>
#include <sstream>
#include <vector>

#include "proto/recording/mcap_bytes.h"
#include "proto/recording/mcap_reader.h"
#include "proto/recording/mcap_writer.h"
#include "tests/server/recorder/sample_ticks.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

std::string load(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

void store(const std::string& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string text_of(int i) {
  return std::string(static_cast<std::size_t>(i % 7), 'x') + std::to_string(i);
}

/// Twelve messages on two channels in four chunks.
std::string small_file(const std::string& path) {
  McapWriter writer;
  REQUIRE(writer.open(path, "test"));
  const std::uint16_t a = writer.add_channel("/a", "A", "schema of A");
  const std::uint16_t b = writer.add_channel("/b", "B", "schema of B");
  for (int i = 0; i < 12; ++i) {
    writer.write(i % 3 == 0 ? b : a, static_cast<std::uint64_t>(i) * 10, text_of(i));
    if (i % 3 == 2) writer.flush();
  }
  REQUIRE(writer.close());
  return load(path);
}

std::vector<std::string> messages_of(McapReader& reader) {
  std::vector<std::string> found;
  McapMessage message;
  while (reader.next(message)) found.emplace_back(message.data);
  return found;
}

/// True when `found` is what was written, from the first message on.
bool is_prefix(const std::vector<std::string>& found) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i] != text_of(static_cast<int>(i))) return false;
  }
  return found.size() <= 12;
}

/// True when `found` is what was written, less some: a chunk whose kind was damaged is passed over.
bool is_part(const std::vector<std::string>& found) {
  int next = 0;
  for (const std::string& message : found) {
    while (next < 12 && text_of(next) != message) ++next;
    if (next++ == 12) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("the CRC is the one of the standard") {
  CHECK(mcap_crc("123456789") == 0xCBF43926U);  // the check value of CRC-32/ISO-HDLC
  CHECK(mcap_crc("") == 0U);
  CHECK(mcap_crc({}, 0xCBF43926U) == 0xCBF43926U);
  CHECK(mcap_crc("6789", mcap_crc("12345")) == 0xCBF43926U);
}

TEST_CASE("what was written is read, in order, with channels, times and counts") {
  const TemporaryFolder folder;
  const std::string bytes = small_file(folder.file("a.mcap"));
  McapReader reader(bytes);
  McapMessage message;
  for (int i = 0; i < 12; ++i) {
    REQUIRE(reader.next(message));
    CHECK(message.data == text_of(i));
    CHECK(message.time_ns == static_cast<std::uint64_t>(i) * 10);
    CHECK(message.channel == reader.channel_of(i % 3 == 0 ? "/b" : "/a"));
    CHECK(message.sequence == static_cast<std::uint32_t>(i % 3 == 0 ? i / 3 : i - i / 3 - 1));
  }
  CHECK_FALSE(reader.next(message));
  CHECK(reader.end() == McapEnd::kComplete);
  CHECK(reader.schemas()[1].data == "schema of B");
  CHECK(reader.channel_of("/c") == 0);
}

TEST_CASE("a file that ends anywhere gives all its whole chunks") {
  const TemporaryFolder folder;
  const std::string bytes = small_file(folder.file("a.mcap"));
  std::size_t most = 0;
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    McapReader reader(std::string_view(bytes).substr(0, length));
    const std::vector<std::string> found = messages_of(reader);
    REQUIRE(is_prefix(found));
    REQUIRE(found.size() % 3 == 0);
    REQUIRE(found.size() >= most);  // a longer file never gives less
    REQUIRE(reader.end() == McapEnd::kTruncated);
    most = found.size();
  }
  CHECK(most == 12);
}

TEST_CASE("no damaged byte is read as a message that was not written, or in another order") {
  const TemporaryFolder folder;
  const std::string bytes = small_file(folder.file("a.mcap"));
  SplitMix64 random(95);
  std::int64_t noticed = 0;
  const std::int64_t count = scaled(200'000);
  for (std::int64_t i = 0; i < count; ++i) {
    std::string damaged = bytes;
    const std::size_t place = random.below(bytes.size());
    damaged[place] = static_cast<char>(damaged[place] ^ static_cast<char>(1U << random.below(8)));
    McapReader reader(damaged);
    if (!is_part(messages_of(reader))) FAIL("byte " << place << " made another message");
    noticed += reader.end() != McapEnd::kComplete ? 1 : 0;
  }
  CHECK(noticed > count / 4);
}

TEST_CASE("a compressed chunk is refused by name, and what is no MCAP at all too") {
  std::string chunk;
  put(chunk, std::uint64_t{0});
  put(chunk, std::uint64_t{0});
  put(chunk, std::uint64_t{5});
  put(chunk, std::uint32_t{0});
  put_text(chunk, "zstd");
  put(chunk, std::uint64_t{5});
  chunk += "12345";
  std::string bytes(kMcapMagic);
  put_record(bytes, McapOpcode::kChunk, chunk);
  McapReader foreign(bytes);
  CHECK(messages_of(foreign).empty());
  CHECK(foreign.end() == McapEnd::kForeign);
  McapReader other("this is a text");
  CHECK(messages_of(other).empty());
  CHECK(other.end() == McapEnd::kBroken);
}

TEST_CASE("messages outside of chunks and records of later versions are read over") {
  std::string message;
  put(message, std::uint16_t{1});
  put(message, std::uint32_t{0});
  put(message, std::uint64_t{42});
  put(message, std::uint64_t{42});
  message += "payload";
  std::string bytes(kMcapMagic);
  put_record(bytes, static_cast<McapOpcode>(0x7F), "who knows");
  put_record(bytes, McapOpcode::kChannel, channel_content({1, 0, "/a", "json"}));
  put_record(bytes, McapOpcode::kMessage, message);
  McapReader reader(bytes);
  McapMessage read;
  REQUIRE(reader.next(read));
  CHECK(read.data == "payload");
  CHECK(read.time_ns == 42);
  CHECK_FALSE(reader.next(read));
}

TEST_CASE("an existing file is not written over") {
  const TemporaryFolder folder;
  store(folder.file("a.mcap"), "precious");
  McapWriter writer;
  CHECK_FALSE(writer.open(folder.file("a.mcap"), "test"));
  CHECK(writer.error().find("a.mcap") != std::string::npos);
  CHECK(load(folder.file("a.mcap")) == "precious");
}

}  // namespace hapticd::test

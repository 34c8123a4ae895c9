// The datagrams of the Stop road: those worked out in proto/PROTOCOL.md, and all others there and
// back.
#include "proto/stop/stop_datagram.h"

#include <doctest/doctest.h>
#include <sodium.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::stop {
namespace {

using test::SplitMix64;

/// A datagram of the document: what its text says, and its bytes.
struct Worked {
  std::map<std::string, std::string> fields;
  std::vector<std::uint8_t> bytes;
};

std::vector<Worked> worked_datagrams() {
  std::ifstream file(HAPTICD_SOURCE_DIR "/proto/PROTOCOL.md");
  REQUIRE(file.good());
  std::vector<Worked> found;
  std::string block;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("```")) {
      block = line.substr(3);
      if (block == "stop") found.push_back({});
    } else if (block == "stop") {
      std::istringstream words(line);
      for (std::string name, value; words >> name >> value;) {
        found.back().fields[name.substr(0, name.size() - 1)] = value;
      }
    } else if (block == "hex stop") {
      std::istringstream words(line.substr(0, line.find('#')));
      for (std::string word; words >> word;) {
        found.back().bytes.push_back(static_cast<std::uint8_t>(std::stoi(word, nullptr, 16)));
      }
    }
  }
  return found;
}

std::uint64_t number(const Worked& worked, const std::string& name) {
  const auto found = worked.fields.find(name);
  return found == worked.fields.end() ? 0 : std::stoull(found->second, nullptr, 0);
}

Kind kind_called(const std::string& name) {
  const std::map<std::string, Kind> kinds{{"STOP", Kind::kStop},
                                          {"QUERY", Kind::kQuery},
                                          {"HEARTBEAT", Kind::kHeartbeat},
                                          {"LEAVE", Kind::kLeave}};
  return kinds.at(name);
}

Key document_key() {
  Key key;
  for (std::size_t k = 0; k < key.size(); ++k) key[k] = static_cast<std::uint8_t>(k);
  return key;
}

Datagram built(const Worked& worked) {
  const auto session_port = static_cast<std::uint16_t>(number(worked, "session_port"));
  const auto timeout_ms = static_cast<std::uint16_t>(number(worked, "timeout_ms"));
  const Challenge challenge{number(worked, "issued_ns"), number(worked, "proof")};
  Datagram datagram;
  if (worked.fields.contains("request")) {
    datagram = encode(Request{kind_called(worked.fields.at("request")), session_port, timeout_ms,
                              number(worked, "client"), number(worked, "number"), challenge});
  } else {
    Answer answer;
    answer.kind = kind_called(worked.fields.at("answer"));
    answer.code = worked.fields.at("code") == "DONE" ? Code::kDone : Code::kChallenge;
    answer.session_port = session_port;
    answer.timeout_ms = timeout_ms;
    answer.latch = static_cast<Latch>(number(worked, "latch"));
    answer.loop_state = static_cast<std::uint8_t>(number(worked, "loop_state"));
    answer.cause = static_cast<std::uint8_t>(number(worked, "cause"));
    answer.tick = static_cast<std::uint32_t>(number(worked, "tick"));
    answer.client = number(worked, "client");
    answer.number = number(worked, "number");
    answer.challenge = challenge;
    datagram = encode(answer);
  }
  if (number(worked, "sealed") != 0) seal(datagram, document_key());
  return datagram;
}

TEST_CASE("what the document says of each Stop datagram gives its bytes") {
  REQUIRE(sodium_init() >= 0);
  const std::vector<Worked> all = worked_datagrams();
  REQUIRE(all.size() == 5);
  for (const Worked& worked : all) {
    const Datagram datagram = built(worked);
    CHECK(std::vector<std::uint8_t>(datagram.begin(), datagram.end()) == worked.bytes);
    CHECK(opens(datagram, document_key()) == (number(worked, "sealed") != 0));
    CHECK(parse_request(worked.bytes).has_value() == worked.fields.contains("request"));
    CHECK(parse_answer(worked.bytes).has_value() == worked.fields.contains("answer"));
  }
}

TEST_CASE("requests and answers come back as they were, and no other key made their tag") {
  REQUIRE(sodium_init() >= 0);
  std::random_device device;
  const std::uint64_t seed = (static_cast<std::uint64_t>(device()) << 32U) | device();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int k = 0; k < test::scaled(20'000); ++k) {
    Request asked;
    asked.kind = static_cast<Kind>(random.below(128));
    asked.session_port = static_cast<std::uint16_t>(random.next());
    asked.timeout_ms = asked.kind == Kind::kHeartbeat ? static_cast<std::uint16_t>(random.next())
                                                      : std::uint16_t{0};
    asked.client = random.next() | 1U;
    asked.number = random.next() | 1U;
    asked.challenge = {random.next(), random.next()};
    Datagram datagram = encode(asked);
    CHECK_FALSE(is_sealed(datagram));
    Key key;
    for (std::uint8_t& byte : key) byte = static_cast<std::uint8_t>(random.next());
    seal(datagram, key);
    const auto read = parse_request(datagram);
    REQUIRE(read);
    CHECK(read->kind == asked.kind);
    CHECK(read->session_port == asked.session_port);
    CHECK(read->timeout_ms == asked.timeout_ms);
    CHECK(read->client == asked.client);
    CHECK(read->number == asked.number);
    CHECK(read->challenge == asked.challenge);
    CHECK(opens(datagram, key));
    CHECK_FALSE(parse_answer(datagram));
    const std::size_t bit = random.below(8 * kDatagramBytes);
    datagram[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    CHECK_FALSE(opens(datagram, key));
  }
}

TEST_CASE("a length other than 64 bytes is no datagram of the road") {
  const Datagram good = encode(Request{Kind::kStop, 0, 0, 1, 1, {}});
  std::vector<std::uint8_t> bytes(good.begin(), good.end());
  REQUIRE(parse_request(bytes));
  for (std::size_t length = 0; length < 200; ++length) {
    bytes.resize(length);
    std::copy_n(good.begin(), std::min(length, good.size()), bytes.begin());
    CHECK(parse_request(bytes).has_value() == (length == kDatagramBytes));
    CHECK_FALSE(parse_answer(bytes));
  }
}

}  // namespace
}  // namespace hapticd::stop

// See replay.h.
#include "tests/fuzz/replay.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "tests/support/random.h"

namespace hapticd::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Longest run of bytes that one mutation moves.
constexpr std::uint64_t kMaxRun = 64;

std::vector<Bytes> read_corpus(const std::string& name) {
  std::vector<std::filesystem::path> paths;
  const std::filesystem::path folder = std::filesystem::path(HAPTICD_CORPUS_DIR) / name;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Bytes> corpus;
  for (const std::filesystem::path& path : paths) {
    std::ifstream file(path, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  if (corpus.empty()) throw std::runtime_error("no corpus in " + folder.string());
  return corpus;
}

std::ptrdiff_t place(SplitMix64& random, const Bytes& bytes) {
  return static_cast<std::ptrdiff_t>(random.below(bytes.size() + 1));
}

/// A run of `bytes` that starts at a random place.
Bytes run(SplitMix64& random, const Bytes& bytes) {
  const std::ptrdiff_t begin = place(random, bytes);
  const auto most = static_cast<std::uint64_t>(std::ssize(bytes) - begin);
  const auto length = static_cast<std::ptrdiff_t>(random.below(std::min(most, kMaxRun) + 1));
  return {bytes.begin() + begin, bytes.begin() + begin + length};
}

void mutate(SplitMix64& random, Bytes& bytes, const Bytes& other) {
  constexpr std::array<std::uint8_t, 6> kEdges{0x00, 0x01, 0x7f, 0x80, 0xfe, 0xff};
  const std::ptrdiff_t at = place(random, bytes);
  switch (random.below(6)) {
    case 0:  // one bit
      if (!bytes.empty())
        bytes[random.below(bytes.size())] ^= static_cast<std::uint8_t>(1U << random.below(8));
      break;
    case 1:  // any byte
      if (!bytes.empty())
        bytes[random.below(bytes.size())] = static_cast<std::uint8_t>(random.next());
      break;
    case 2:  // a byte at the edge of its range
      if (!bytes.empty()) bytes[random.below(bytes.size())] = kEdges[random.below(kEdges.size())];
      break;
    case 3: {  // a run removed
      const std::ptrdiff_t length = std::ssize(run(random, bytes));
      const std::ptrdiff_t begin = std::min(at, std::ssize(bytes) - length);
      bytes.erase(bytes.begin() + begin, bytes.begin() + begin + length);
      break;
    }
    case 4: {  // a run of its own or of another input put in
      const Bytes added = run(random, random.chance(0.5) ? bytes : other);
      bytes.insert(bytes.begin() + at, added.begin(), added.end());
      break;
    }
    default: {  // a run of another input written over
      const Bytes added = run(random, other);
      const std::ptrdiff_t length = std::min(std::ssize(added), std::ssize(bytes) - at);
      std::copy_n(added.begin(), length, bytes.begin() + at);
      break;
    }
  }
}

}  // namespace

Replay replay(const std::string& name, std::int64_t mutations, const FuzzTarget& target) {
  const std::vector<Bytes> corpus = read_corpus(name);
  Replay result;
  const auto feed = [&](const Bytes& bytes) {
    ++result.inputs;
    result.taken += target(bytes) ? 1 : 0;
  };
  feed({});
  for (const Bytes& bytes : corpus) feed(bytes);
  SplitMix64 random(1);
  for (std::int64_t k = 0; k < mutations; ++k) {
    Bytes bytes = corpus[random.below(corpus.size())];
    for (std::uint64_t n = 1 + random.below(4); n > 0; --n) {
      mutate(random, bytes, corpus[random.below(corpus.size())]);
    }
    feed(bytes);
  }
  return result;
}

}  // namespace hapticd::test

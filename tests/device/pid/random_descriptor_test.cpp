// Report descriptors of composite devices, made at random: a stick that pushes among mice, game
// pads, keyboards and what makers add, in any order. Truth: where the generator, which shares no
// code with the reader, put each number.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "device/pid/pid_layout.h"
#include "tests/device/pid/force_device.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Where a number was put.
struct Place {
  unsigned report = 0, bit = 0, bits = 0;
  std::int64_t minimum = 0, maximum = 0;
};

void check_place(const pid::BitField& field, const Place& place) {
  CHECK(unsigned{field.bit} == place.bit);
  CHECK(unsigned{field.bits} == place.bits);
  CHECK(field.minimum == place.minimum);
  CHECK(field.maximum == place.maximum);
}

/// Writes a descriptor item by item and counts bits.
class Writer {
 public:
  explicit Writer(SplitMix64& random) : random_(random) {
    std::iota(ids_.begin(), ids_.end(), std::uint8_t{1});
    for (std::size_t k = ids_.size() - 1; k > 0; --k) std::swap(ids_[k], ids_[random.below(k + 1)]);
  }

  void item(unsigned prefix, std::int64_t value) {
    const bool small =
        prefix == 0x14 || prefix == 0x24 ? value >= -128 && value < 128 : value >= 0 && value < 256;
    const bool middle = prefix == 0x14 || prefix == 0x24 ? value >= -32'768 && value < 32'768
                                                         : value >= 0 && value < 65'536;
    const unsigned size = small ? 1 : middle ? 2 : 4;
    bytes.push_back(static_cast<std::uint8_t>(prefix | (size == 4 ? 3U : size)));
    for (unsigned i = 0; i < size; ++i) {
      bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
    }
  }
  void page(unsigned number) { item(0x04, number); }
  void usage(unsigned number) { item(0x08, number); }
  void open(unsigned page_number, unsigned usage_number, unsigned type) {
    page(page_number);
    usage(usage_number);
    item(0xA0, type);
  }
  void close() { bytes.push_back(0xC0); }
  /// A new report.
  unsigned report() {
    report_ = ids_[next_id_++];
    item(0x84, report_);
    return report_;
  }
  /// Fields of these usages, in this page; `flags` as the main item has them.
  std::vector<Place> fields(unsigned kind, unsigned page_number,
                            const std::vector<unsigned>& usages, Place like, unsigned flags = 2) {
    page(page_number);
    for (const unsigned number : usages) usage(number);
    item(0x14, like.minimum);
    item(0x24, like.maximum);
    item(0x74, like.bits);
    item(0x94, static_cast<std::int64_t>(usages.size()));
    item(kind, flags);
    std::vector<Place> placed;
    unsigned& at = bits_.try_emplace({kind, report_}, 8U).first->second;
    for (std::size_t k = 0; k < usages.size(); ++k) {
      placed.push_back(like);
      placed.back().report = report_;
      placed.back().bit = at;
      at += like.bits;
    }
    return placed;
  }
  /// Bits of nothing.
  void pad() {
    const auto bits = static_cast<unsigned>(random_.below(13));
    if (bits == 0) return;
    item(0x74, 1);
    item(0x94, bits);
    item(0x80, 3);
    bits_.try_emplace({0x80U, report_}, 8U).first->second += bits;
  }

  Bytes bytes;

 private:
  SplitMix64& random_;
  std::array<std::uint8_t, 60> ids_{};
  std::size_t next_id_ = 0;
  unsigned report_ = 0;
  std::map<std::pair<unsigned, unsigned>, unsigned> bits_;
};

constexpr unsigned kInput = 0x80, kOutput = 0x90, kFeature = 0xB0;

Place range(unsigned bits, std::int64_t minimum, std::int64_t maximum) {
  return {0, 0, bits, minimum, maximum};
}

/// A range of an axis that its bits hold.
Place axis_range(SplitMix64& random) {
  const auto bits = static_cast<unsigned>(8 + random.below(9));
  const std::int64_t half = std::int64_t{1} << (bits - 1);
  return random.chance(0.5) ? range(bits, -half + 1, half - 1) : range(bits, 0, 2 * half - 1);
}

void add_mouse(Writer& writer, SplitMix64& random) {
  writer.open(1, 2, 1);
  writer.open(1, 1, 0);
  writer.report();
  writer.pad();
  writer.fields(kInput, 1, {0x30, 0x31}, range(8, -127, 127), random.chance(0.8) ? 6 : 2);
  writer.close();
  writer.close();
}

void add_keyboard(Writer& writer) {
  writer.open(1, 6, 1);
  writer.report();
  writer.fields(kInput, 7, {0xE0, 0xE1, 0xE2}, range(1, 0, 1));
  writer.close();
}

void add_vendor(Writer& writer) {
  writer.open(0xFF00, 1, 1);
  writer.report();
  writer.fields(kInput, 1, {0x31, 0x30}, range(12, 0, 4095));
  writer.close();
}

/// A game pad without motors, or a tablet.
void add_pad(Writer& writer, SplitMix64& random) {
  if (random.chance(0.5)) {
    writer.open(1, 5, 1);
  } else {
    writer.open(0x0D, 1, 1);
  }
  writer.report();
  writer.fields(kInput, 1, {0x30, 0x31}, axis_range(random));
  writer.close();
}

struct Stick {
  Place x, y, switch_off, motors;
  bool has_state = false;
};

/// The stick that pushes; `axes`: how many Axes Enable names, 0: it is left out.
Stick add_stick(Writer& writer, SplitMix64& random, int axes) {
  Stick stick;
  const Place block = range(8, 1, 40);
  writer.open(1, random.chance(0.7) ? 4 : 5, 1);
  const bool pointer = random.chance(0.5);
  const auto add_axes = [&] {
    if (pointer) writer.open(1, 1, 0);
    if (random.chance(0.3)) {
      // Changes and a place without a range come first, in a report of their own.
      writer.report();
      writer.fields(kInput, 1, {0x30, 0x31}, range(8, -127, 127), 6);
    }
    writer.report();
    writer.pad();
    const Place both = axis_range(random);
    if (random.chance(0.3)) writer.fields(kInput, 1, {0x30}, range(8, -127, 127), 6);
    if (random.chance(0.5)) {
      const auto placed = writer.fields(kInput, 1, {0x30, 0x31, 0x35}, both);
      stick.x = placed[0];
      stick.y = placed[1];
    } else {
      stick.y = writer.fields(kInput, 1, {0x31}, both)[0];
      writer.pad();
      stick.x = writer.fields(kInput, 1, {0x32, 0x30}, axis_range(random))[1];
    }
    if (pointer) writer.close();
  };
  const auto add_state = [&] {
    stick.has_state = random.chance(0.7);
    if (!stick.has_state) return;
    writer.open(0x0F, 0x92, 2);
    writer.report();
    writer.pad();
    const auto flags = writer.fields(kInput, 0x0F, {0x9F, 0xA0, 0xA4, 0xA6}, range(1, 0, 1));
    stick.motors = flags[1];
    stick.switch_off = flags[2];
    writer.close();
  };
  const auto add_effect = [&] {
    writer.open(0x0F, 0x21, 2);
    writer.report();
    writer.fields(kOutput, 0x0F, {0x22}, block);
    writer.open(0x0F, 0x25, 2);
    writer.fields(kOutput, 0x0F, {0x26}, range(8, 1, 1), 0);
    writer.close();
    writer.fields(kOutput, 0x0F, {0x52}, range(8, 0, 255));
    if (axes > 0) {
      writer.open(0x0F, 0x55, 2);
      const auto one = static_cast<unsigned>(random.chance(0.5) ? 0x30 : 0x31);
      writer.fields(kOutput, 1,
                    axes == 1 ? std::vector<unsigned>{one} : std::vector<unsigned>{0x30, 0x31},
                    range(1, 0, 1));
      writer.close();
    }
    writer.fields(kOutput, 0x0F, {0x56}, range(1, 0, 1));
    writer.open(0x0F, 0x57, 2);
    writer.fields(kOutput, 0x0A, {1, 2}, range(16, 0, 36'000));
    writer.close();
    writer.close();
  };
  const auto add_rest = [&] {
    writer.open(0x0F, 0x73, 2);
    writer.report();
    writer.fields(kOutput, 0x0F, {0x22}, block);
    writer.fields(kOutput, 0x0F, {0x70}, range(16, -10'000, 10'000));
    writer.close();
    writer.open(0x0F, 0x77, 2);
    writer.report();
    writer.fields(kOutput, 0x0F, {0x22}, block);
    writer.open(0x0F, 0x78, 2);
    writer.fields(kOutput, 0x0F, {0x79}, range(8, 1, 1), 0);
    writer.close();
    writer.close();
    writer.open(0x0F, 0x95, 2);
    writer.report();
    writer.open(0x0F, 0x96, 2);
    writer.fields(kOutput, 0x0F, {0x97}, range(8, 1, 1), 0);
    writer.close();
    writer.close();
    writer.open(0x0F, 0xAB, 2);
    writer.report();
    writer.open(0x0F, 0x25, 2);
    writer.fields(kFeature, 0x0F, {0x26}, range(8, 1, 1), 0);
    writer.close();
    writer.close();
    writer.open(0x0F, 0x89, 2);
    writer.report();
    writer.fields(kFeature, 0x0F, {0x22}, block);
    writer.open(0x0F, 0x8B, 2);
    writer.fields(kFeature, 0x0F, {0x8C}, range(8, 1, 1), 0);
    writer.close();
    writer.close();
  };
  const bool axes_first = random.chance(0.5);
  if (axes_first) add_axes();
  add_state();
  add_effect();
  add_rest();
  if (!axes_first) add_axes();
  writer.close();
  return stick;
}

/// Up to four other devices around a stick whose Axes Enable names so many.
Stick add_devices(Writer& writer, SplitMix64& random, int axes) {
  const std::size_t others = random.below(5);
  const std::size_t place = random.below(others + 1);
  Stick stick;
  for (std::size_t k = 0; k <= others; ++k) {
    if (k == place) {
      stick = add_stick(writer, random, axes);
      continue;
    }
    const std::uint64_t kind = random.below(4);
    if (kind == 0) add_mouse(writer, random);
    if (kind == 1) add_keyboard(writer);
    if (kind == 2) add_vendor(writer);
    if (kind == 3) add_pad(writer, random);
  }
  return stick;
}

}  // namespace

TEST_CASE("of any devices in one descriptor the position is that of the stick that pushes") {
  SplitMix64 random(fresh_seed());
  for (std::int64_t k = 0; k < scaled(3000); ++k) {
    Writer writer(random);
    const Stick stick = add_devices(writer, random, random.chance(0.5) ? 2 : 0);
    const pid::LayoutResult found = pid::find_layout(writer.bytes);
    REQUIRE(found.lack == "");
    CHECK(found.layout.input.report.id == stick.x.report);
    check_place(found.layout.input.x, stick.x);
    check_place(found.layout.input.y, stick.y);
    const pid::PidLayout::State& state = found.layout.state;
    REQUIRE((state.report.bytes != 0) == stick.has_state);
    if (!stick.has_state) continue;
    CHECK(state.report.id == stick.motors.report);
    check_place(state.actuators, stick.motors);
    check_place(state.safety_switch, stick.switch_off);
  }
}

TEST_CASE("a wheel, whose effects are along one axis, is refused wherever it stands") {
  SplitMix64 random(fresh_seed());
  for (std::int64_t k = 0; k < scaled(1000); ++k) {
    Writer writer(random);
    add_devices(writer, random, 1);
    CHECK(pid::find_layout(writer.bytes).lack.find("second axis") != std::string::npos);
  }
}

}  // namespace hapticd::test

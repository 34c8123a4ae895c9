// Recorded tones: what is played from a folder, and what is said about files that cannot be. The
// recordings are sines that the test writes itself.
#include "clients/audio/tone_files.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <memory>
#include <numbers>
#include <sndfile.hh>
#include <string>
#include <utility>
#include <vector>

#include "clients/audio/audio_engine.h"
#include "clients/audio/event_player.h"
#include "clients/audio/render.h"
#include "clients/audio/sound_file.h"
#include "tests/clients/audio/played.h"
#include "tests/clients/audio/temporary_folder.h"
#include "tests/clients/audio/tone_measure.h"
#include "tests/support/random.h"
#include "tests/support/within.h"

namespace hapticd::audio {
namespace {

constexpr double kRate_hz = 48000.0;

/// G2.
constexpr double kSine_hz = 98.0;

void write_sine(const std::filesystem::path& path, double amplitude, double length_s,
                int rate_hz = 48000, int channels = 1) {
  const auto frames = static_cast<std::size_t>(length_s * rate_hz);
  std::vector<float> samples;
  for (std::size_t i = 0; i < frames; ++i) {
    const double angle = 2.0 * std::numbers::pi * kSine_hz * static_cast<double>(i) / rate_hz;
    for (int c = 0; c < channels; ++c)
      samples.push_back(static_cast<float>(amplitude * std::sin(angle)));
  }
  SndfileHandle file(path.string(), SFM_WRITE, SF_FORMAT_WAV | SF_FORMAT_FLOAT, channels, rate_hz);
  REQUIRE_EQ(file.writef(samples.data(), static_cast<sf_count_t>(frames)), frames);
}

v1::Scene scene_with(const std::string& name, double frequency_hz) {
  v1::Scene scene;
  scene.add_strings()->set_name(name);
  scene.mutable_strings(0)->set_frequency_hz(frequency_hz);
  return scene;
}

v1::Item tone(float frequency_hz, float level, float decay_s = 0.5F) {
  v1::Item item;
  item.mutable_tone()->set_frequency_hz(frequency_hz);
  item.mutable_tone()->set_level(level);
  item.mutable_tone()->set_lambda(0.1F);
  item.mutable_tone()->set_decay_s(decay_s);
  return item;
}

/// One tone of the scene's only string, as heard.
std::vector<float> heard(ToneFiles* files, const v1::Scene& scene, const v1::Item& item,
                         double length_s, double rate_hz = kRate_hz) {
  const Sound sound = test::whole(rate_hz);
  const auto engine = std::make_unique<AudioEngine>(sound.body);
  EventPlayer player(sound, files, [&](const Order& order) { return engine->submit(order); });
  player.set_scene(scene);
  player.play(item, 0);
  std::vector<float> frames(static_cast<std::size_t>(length_s * rate_hz));
  MidiEvents notes;
  engine->render({0, 0, 1e9 / rate_hz}, 0, frames, notes);
  return frames;
}

}  // namespace

TEST_CASE(
    "a recording sounds as it is at the string's own pitch, and at another pitch when that "
    "sounds") {
  const test::TemporaryFolder folder;
  write_sine(folder.path() / "G2.wav", 0.3, 3.0);
  ToneFiles files(folder.path(), kRate_hz);
  const v1::Scene scene = scene_with("G2", 98.0);
  for (const float frequency_hz : {98.0F, 49.0F, 110.0F, 196.0F}) {
    const auto sound = heard(&files, scene, tone(frequency_hz, 0.5F), 1.2);
    const double pitch = static_cast<double>(frequency_hz);
    const double measured = test::frequency_near(sound, kRate_hz, pitch * 1.001, 0.1, 0.4, 0.4);
    CHECK(std::abs(test::cents(measured, pitch)) < 0.01);
  }
  const auto sound = heard(&files, scene, tone(98.0F, 0.5F), 1.0);
  const double rms = 0.3 / std::numbers::sqrt2;
  for (std::size_t i = 0; i < sound.size(); i += 97) {
    const double angle = 2.0 * std::numbers::pi * 98.0 * static_cast<double>(i) / kRate_hz;
    const double expected = 0.3 * std::sin(angle) * 0.5 * kLevelRms / rms;
    CHECK(static_cast<double>(sound[i]) == doctest::Approx(expected).epsilon(2e-3).scale(0.05));
  }
  CHECK(files.problems().empty());
}

TEST_CASE("recordings of any level and the computed string are equally loud at the same event") {
  const test::TemporaryFolder folder;
  write_sine(folder.path() / "soft.wav", 0.01, 1.0);
  write_sine(folder.path() / "loud.wav", 0.9, 1.0);
  ToneFiles files(folder.path(), kRate_hz);
  for (const float level : {0.1F, 0.5F, 1.0F}) {
    const double expected = static_cast<double>(level) * kLevelRms;
    for (const char* const name : {"soft", "loud", "no such file"}) {
      const auto sound = heard(&files, scene_with(name, 98.0), tone(98.0F, level), 0.5);
      CHECK(test::rms(sound, kRate_hz, 0.0, kLevelWindow_s) == test::within(expected, 0.03));
    }
  }
}

TEST_CASE(
    "a recording of any sample rate sounds at its pitch and level, at any rate of the output") {
  const test::TemporaryFolder folder;
  const int rates[] = {44100, 22050, 48000, 96000, 44101};
  for (const int rate_hz : rates) {
    write_sine(folder.path() / ("r" + std::to_string(rate_hz) + ".wav"), 0.3, 1.5, rate_hz);
  }
  for (const double output_hz : {48000.0, 44100.0}) {
    ToneFiles files(folder.path(), output_hz);
    for (const int rate_hz : rates) {
      const v1::Scene scene = scene_with("r" + std::to_string(rate_hz), 98.0);
      const auto sound = heard(&files, scene, tone(98.0F, 0.5F), 1.2, output_hz);
      CAPTURE(rate_hz);
      const double pitch = test::frequency_near(sound, output_hz, 98.05, 0.1, 0.4, 0.4);
      CHECK(std::abs(test::cents(pitch, 98.0)) < 0.01);
      CHECK(test::rms(sound, output_hz, 0.0, kLevelWindow_s) ==
            test::within(0.5 * kLevelRms, 2e-3));
    }
    CHECK(files.problems().empty());
  }
}

namespace {

/// A sine of 98 Hz and 1 s whose frame `at` is `value`, after `silence_s` of noise of that level.
void write_marred(const std::filesystem::path& path, std::size_t at, float value,
                  double silence_s = 0.0, float noise = 0.0F) {
  test::SplitMix64 random(4);
  const std::int64_t silent = std::lround(silence_s * 48000);
  std::vector<float> samples;
  samples.reserve(static_cast<std::size_t>(silent) + 48000);
  for (std::int64_t i = 0; i < silent; ++i)
    samples.push_back(noise * static_cast<float>(random.uniform(-1.0, 1.0)));
  for (int i = 0; i < 48000; ++i)
    samples.push_back(
        static_cast<float>(0.3 * std::cos(2.0 * std::numbers::pi * 98.0 * i / 48000)));
  if (at < samples.size()) samples[at] = value;
  SndfileHandle file(path.string(), SFM_WRITE, SF_FORMAT_WAV | SF_FORMAT_FLOAT, 1, 48000);
  REQUIRE_EQ(file.writef(samples.data(), static_cast<sf_count_t>(samples.size())), samples.size());
}

constexpr std::size_t kNowhere = SIZE_MAX;

}  // namespace

TEST_CASE(
    "a recording with a sample that is no sound is refused by name and place, wherever it is") {
  const test::TemporaryFolder folder;
  test::SplitMix64 random(30);
  const float infinity = std::numeric_limits<float>::infinity();
  const std::pair<float, const char*> values[] = {
      {std::numeric_limits<float>::quiet_NaN(), "not sound, nan"},
      {infinity, "not sound, inf"},
      {-infinity, "not sound, -inf"},
      {1e30F, "not sound, 1e+30"},
      {-3e38F, "not sound, -3e+38"},
      {1e9F, "stray sample"},
      {300.0F, "stray sample"}};
  int number = 0;
  for (const auto& [value, words] : values) {
    for (const std::size_t at : {std::size_t{0}, std::size_t{47999}, std::size_t{24000},
                                 static_cast<std::size_t>(random.below(48000))}) {
      const std::string name = "s" + std::to_string(number++);
      write_marred(folder.path() / (name + ".wav"), at, value);
      ToneFiles files(folder.path(), kRate_hz);
      CHECK(files.find(name) == nullptr);
      REQUIRE_EQ(files.problems().size(), 1);
      CAPTURE(files.problems()[0]);
      CHECK(files.problems()[0].find(name + ".wav: has a ") != std::string::npos);
      CHECK(files.problems()[0].find(words) != std::string::npos);
    }
  }
  // A hard click at the onset, and samples as integers of 32 bits, are sound.
  write_marred(folder.path() / "click.wav", 5, 4.0F);
  ToneFiles files(folder.path(), kRate_hz);
  CHECK(files.find("click") != nullptr);
}

TEST_CASE("silence before a tone is cut off and said; a tone that begins at once stays as it is") {
  const test::TemporaryFolder folder;
  for (const float noise : {0.0F, 1e-4F, 2e-3F}) {
    for (const double silence_s : {0.02, 0.1, 1.7}) {
      const std::string name = "late" + std::to_string(silence_s) + std::to_string(noise);
      write_marred(folder.path() / (name + ".wav"), kNowhere, 0.0F, silence_s, noise);
      ToneFiles files(folder.path(), kRate_hz);
      const v1::Scene scene = scene_with(name, 98.0);
      const auto sound = heard(&files, scene, tone(98.0F, 1.0F), 0.9);
      CAPTURE(name);
      CHECK(files.problems().empty());
      REQUIRE_EQ(files.notes().size(), 1);
      CHECK(files.notes()[0].find(name + ".wav: begins with") != std::string::npos);
      // A cosine stands at its peak at once; 1 ms is left before it.
      const auto loud = std::find_if(sound.begin(), sound.end(), [](float frame) {
        return std::abs(frame) > 0.5F * static_cast<float>(kLevelRms);
      });
      CHECK(loud - sound.begin() <= 49);
      CHECK(test::rms(sound, kRate_hz, 0.0, kLevelWindow_s) == test::within(kLevelRms, 5e-3));
    }
  }
  write_marred(folder.path() / "prompt.wav", kNowhere, 0.0F);
  ToneFiles files(folder.path(), kRate_hz);
  const ToneFile* const prompt = files.find("prompt");
  REQUIRE(prompt != nullptr);
  CHECK_EQ(prompt->samples.size(), 48000);
  CHECK_EQ(prompt->samples[0], 0.3F);
  CHECK(files.notes().empty());
}

TEST_CASE("missing, short, silent and unreadable files are named with the remedy") {
  const test::TemporaryFolder folder;
  write_sine(folder.path() / "short.wav", 0.3, 0.4);
  write_sine(folder.path() / "rate.wav", 0.3, 1000.0, 100);
  write_sine(folder.path() / "silent.wav", 0.0, 1.0);
  std::ofstream(folder.path() / "junk.wav") << "no sound at all";
  ToneFiles files(folder.path(), kRate_hz);
  const auto problem_of = [&](const std::string& name) {
    const std::size_t before = files.problems().size();
    CHECK(files.find(name) == nullptr);
    CHECK(files.find(name) == nullptr);
    REQUIRE_EQ(files.problems().size(), before + 1);
    return files.problems().back();
  };
  const auto names = [](const std::string& text, const char* part) {
    CAPTURE(text);
    CHECK(text.find(part) != std::string::npos);
  };
  names(problem_of("short"), "short.wav: is too short: 0.40 s");
  names(problem_of("rate"), "rate.wav: has a sample rate of 100 Hz");
  names(problem_of("silent"), "silent.wav: is silent");
  names(problem_of("junk"), "junk.wav: cannot be read");
  names(problem_of("absent"), "absent.wav: is missing");
  names(problem_of("../rate"), "is missing");
  names(problem_of(""), "is missing");
}

TEST_CASE("a recording in stereo is mixed, and its end is silence") {
  const test::TemporaryFolder folder;
  write_sine(folder.path() / "G2.wav", 0.3, 0.6, 48000, 2);
  ToneFiles files(folder.path(), kRate_hz);
  const ToneFile* const file = files.find("G2");
  REQUIRE(file != nullptr);
  CHECK_EQ(file->samples.size(), 28800);
  CHECK(file->rms == test::within(0.3 / std::numbers::sqrt2, 0.01));
  const auto sound = heard(&files, scene_with("G2", 98.0), tone(98.0F, 1.0F), 1.0);
  for (std::size_t i = 28800; i < sound.size(); ++i) CHECK_EQ(sound[i], 0.0F);
}

TEST_CASE("the shipped tones have the pitch, level and decay of the computed strings") {
  const test::TemporaryFolder folder;
  render_tone_files(folder.path().string(), kRate_hz);
  ToneFiles files(folder.path(), kRate_hz);
  for (const OpenString& open : kZhengDiao) {
    const v1::Scene scene = scene_with(open.name, open.frequency_hz);
    const v1::Item item = tone(static_cast<float>(open.frequency_hz), 0.7F);
    const auto recorded = heard(&files, scene, item, 2.0);
    const auto computed = heard(nullptr, scene, item, 2.0);
    CAPTURE(open.name);
    REQUIRE(files.find(open.name) != nullptr);
    CHECK(files.find(open.name)->frequency_hz == test::within(open.frequency_hz, 1e-6));
    for (const auto* const sound : {&recorded, &computed}) {
      const double pitch =
          test::frequency_near(*sound, kRate_hz, open.frequency_hz * 1.001, 0.1, 0.4, 0.4);
      CHECK(std::abs(test::cents(pitch, open.frequency_hz)) < 0.02);
      CHECK(test::rms(*sound, kRate_hz, 0.0, kLevelWindow_s) ==
            test::within(0.7 * kLevelRms, 0.03));
      CHECK(test::decay_near(*sound, kRate_hz, open.frequency_hz, 0.1, 0.4, 0.4) ==
            test::within(0.5, 5e-3));
      CHECK(*std::max_element(sound->begin(), sound->end()) < 1.0F);
    }
  }
  CHECK(files.problems().empty());
}

TEST_CASE("sound is written to .wav and .flac alone, and the same sound gives the same bytes") {
  const test::TemporaryFolder folder;
  const std::vector<float> frames{0.0F, 0.25F, -0.5F, 0.125F};
  CHECK_THROWS_WITH_AS(SoundFile(folder.path() / "a.mp3", kRate_hz),
                       doctest::Contains("sound is written to .wav or .flac"), std::runtime_error);
  CHECK_THROWS_AS(SoundFile(folder.path() / "none" / "a.wav", kRate_hz), std::runtime_error);
  for (const char* const ending : {".wav", ".flac"}) {
    std::string contents[2];
    for (const int run : {0, 1}) {
      const auto path = folder.path() / (std::to_string(run) + ending);
      SoundFile(path, kRate_hz, 98.0).write(frames);
      std::ifstream file(path, std::ios::binary);
      contents[run].assign(std::istreambuf_iterator<char>(file), {});
      SndfileHandle back(path.string());
      std::vector<float> read(8);
      CHECK_EQ(back.readf(read.data(), 8), 4);
      CHECK_EQ(read[2], -0.5F);
      CHECK_EQ(frequency_of(back.getString(SF_STR_COMMENT)), 98.0);
    }
    CHECK(contents[0] == contents[1]);
    CHECK(contents[0].size() > 20);
    // The chunk of that name has the date in it, to the second.
    CHECK(contents[0].find("PEAK") == std::string::npos);
  }
}

}  // namespace hapticd::audio

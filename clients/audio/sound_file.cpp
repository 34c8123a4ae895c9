// See sound_file.h.
#include "clients/audio/sound_file.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sndfile.hh>
#include <stdexcept>
#include <string>

namespace hapticd::audio {
namespace {

constexpr const char* kFrequency = "frequency_hz=";

int format_of(const std::filesystem::path& path) {
  if (path.extension() == ".wav") return SF_FORMAT_WAV | SF_FORMAT_FLOAT;
  if (path.extension() == ".flac") return SF_FORMAT_FLAC | SF_FORMAT_PCM_24;
  throw std::runtime_error(path.string() + ": sound is written to .wav or .flac");
}

}  // namespace

SoundFile::SoundFile(const std::filesystem::path& path, double rate_hz, double frequency_hz)
    : path_(path),
      file_(std::make_unique<SndfileHandle>(path.string(), SFM_WRITE, format_of(path), 1,
                                            static_cast<int>(std::lround(rate_hz)))) {
  if (file_->error() != SF_ERR_NO_ERROR) {
    throw std::runtime_error(path.string() + ": " + file_->strError());
  }
  // The chunk with the peak has the date in it.
  file_->command(SFC_SET_ADD_PEAK_CHUNK, nullptr, SF_FALSE);
  file_->command(SFC_SET_CLIPPING, nullptr, SF_TRUE);
  if (frequency_hz > 0.0) {
    char text[48];
    std::snprintf(text, sizeof text, "%s%.6g", kFrequency, frequency_hz);
    file_->setString(SF_STR_COMMENT, text);
  }
}

SoundFile::~SoundFile() = default;

void SoundFile::write(std::span<const float> frames) {
  const auto count = static_cast<sf_count_t>(frames.size());
  if (file_->writef(frames.data(), count) != count) {
    throw std::runtime_error(path_.string() + ": " + file_->strError());
  }
}

double frequency_of(const char* comment) {
  const char* const place = comment == nullptr ? nullptr : std::strstr(comment, kFrequency);
  if (place == nullptr) return 0.0;
  const double frequency_hz = std::strtod(place + std::strlen(kFrequency), nullptr);
  return frequency_hz > 0.0 && frequency_hz <= 2e4 ? frequency_hz : 0.0;
}

}  // namespace hapticd::audio

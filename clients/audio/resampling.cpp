// See resampling.h.
#include "clients/audio/resampling.h"

#include <samplerate.h>

#include <cstdint>
#include <stdexcept>

namespace hapticd::audio {

std::vector<float> resampled(std::span<const float> samples, int from_hz, int to_hz) {
  if (from_hz == to_hz || samples.empty()) return {samples.begin(), samples.end()};
  const auto size = static_cast<std::int64_t>(samples.size());
  std::vector<float> out(static_cast<std::size_t>((size * to_hz + from_hz - 1) / from_hz));
  SRC_DATA data{};
  data.data_in = samples.data();
  data.input_frames = static_cast<long>(size);
  data.data_out = out.data();
  data.output_frames = static_cast<long>(out.size());
  data.src_ratio = static_cast<double>(to_hz) / from_hz;
  const int error = src_simple(&data, SRC_SINC_BEST_QUALITY, 1);
  if (error != 0) throw std::runtime_error(src_strerror(error));
  return out;
}

}  // namespace hapticd::audio

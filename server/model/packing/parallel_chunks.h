// Work on the indices 0 ... count - 1 in fixed chunks by several threads. Which thread takes which
// chunk is left to chance, so results must depend on the index alone: write to places of the index
// or of the chunk, and reduce afterwards in order. Offline.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace hapticd {

/// Number of chunks of `size` (>= 1) that `count` (>= 0) indices take.
[[nodiscard]] constexpr std::int64_t chunk_count(std::int64_t count, std::int64_t size) noexcept {
  return (count + size - 1) / size;
}

/// Calls work(chunk, begin, end) once for every chunk of `size` indices (the last may be smaller),
/// from up to `threads` (>= 1) threads, the calling one among them. Rethrows the first exception of
/// the work after all threads have ended.
template <typename Work>
void for_chunks(std::int64_t count, std::int64_t size, int threads, const Work& work) {
  const std::int64_t chunks = chunk_count(count, size);
  std::atomic<std::int64_t> next{0};
  std::exception_ptr error;
  std::mutex error_mutex;
  const auto run = [&] {
    try {
      for (std::int64_t c = next++; c < chunks; c = next++) {
        work(c, c * size, std::min(count, (c + 1) * size));
      }
    } catch (...) {
      const std::lock_guard<std::mutex> lock(error_mutex);
      if (!error) error = std::current_exception();
      next = chunks;
    }
  };
  std::vector<std::thread> helpers;
  const std::int64_t wanted = std::min<std::int64_t>(threads, chunks);
  for (std::int64_t i = 1; i < wanted; ++i) helpers.emplace_back(run);
  run();
  for (std::thread& helper : helpers) helper.join();
  if (error) std::rethrow_exception(error);
}

}  // namespace hapticd

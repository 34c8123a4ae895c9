// A library that does everything the realtime path must not, so that check_symbols.py can be seen
// to find it. Never linked.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>
#include <vector>

namespace hapticd::test {

int* allocate() { return new int(3); }
void release(const int* block) { delete block; }
void* allocate_c() { return std::malloc(8); }
void release_c(void* block) { std::free(block); }
void fail() { throw 3; }
double element(const std::vector<double>& values) { return values.at(3); }
void print(double value) { std::printf("%g\n", value); }
double sine(double angle) { return std::sin(angle); }
double power(double base, double exponent) { return std::pow(base, exponent); }

void lock() {
  static std::mutex mutex;
  const std::lock_guard<std::mutex> guard(mutex);
}

const std::string& guarded(const char* text) {
  static const std::string name(text);
  return name;
}

}  // namespace hapticd::test

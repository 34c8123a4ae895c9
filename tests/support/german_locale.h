// A program that follows its locale, where that is German: numbers have a decimal comma. Not RT.
#pragma once

#include <string>

namespace hapticd::test {

/// The locale of this process is German until the end of the block. glibc alone makes it: one
/// thread at a time, and no other may write numbers meanwhile.
class GermanLocale {
 public:
  /// Makes the locale in a folder of its own, in about 0.2 s, and puts it in force.
  GermanLocale();
  ~GermanLocale();
  GermanLocale(const GermanLocale&) = delete;
  GermanLocale& operator=(const GermanLocale&) = delete;

  /// Whether printf writes a comma; false where no locale can be made, and said() tells why.
  [[nodiscard]] bool in_force() const;
  [[nodiscard]] const std::string& said() const { return said_; }

 private:
  std::string folder_;
  std::string said_;
};

}  // namespace hapticd::test

// See german_locale.h.
#include "tests/support/german_locale.h"

#include <stdlib.h>

#include <clocale>
#include <filesystem>
#include <string_view>

#include "tests/support/shell_run.h"

namespace hapticd::test {

// NOLINTBEGIN(concurrency-mt-unsafe): a test that asks for it has one thread

GermanLocale::GermanLocale() {
  folder_ = (std::filesystem::temp_directory_path() / "hapticd-locale-XXXXXX").string();
  if (::mkdtemp(folder_.data()) == nullptr) return;
  said_ = run_in_shell("localedef -c -i de_DE -f UTF-8 '" + folder_ + "/de_DE.UTF-8' 2>&1").text;
  ::setenv("LOCPATH", folder_.c_str(), 1);
  std::setlocale(LC_ALL, "de_DE.UTF-8");
}

GermanLocale::~GermanLocale() {
  std::setlocale(LC_ALL, "C");
  ::unsetenv("LOCPATH");
  std::filesystem::remove_all(folder_);
}

bool GermanLocale::in_force() const {
  return std::string_view(std::localeconv()->decimal_point) == ",";
}

// NOLINTEND(concurrency-mt-unsafe)

}  // namespace hapticd::test

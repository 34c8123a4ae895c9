# Language level, flags that every target shares, sanitizers, and the helpers (ccache, mold) that only save time.
#
# Cache variables, normally set by CMakePresets.json:
#   HAPTICD_SANITIZE    value of -fsanitize=, e.g. "address,undefined"; empty = none
#   HAPTICD_COVERAGE    instrument for gcov
#   HAPTICD_WERROR      warnings are errors
#   HAPTICD_HARDENED    guards against what an attacker could make of a mistake; some percent dearer
#   HAPTICD_UNITY       compile sources together (deploy/cmake/unity_groups.py): half the work where nothing was compiled before
#   HAPTICD_TEST_SCALE  default of the environment variable of that name in tests (tests/support/scale.h)
#   HAPTICD_BENCHMARKS  build tests/benchmark
#   HAPTICD_VM_TESTS    the tests in tests/vm, which boot a kernel
#   HAPTICD_FINE_MODELS   make the finest trees too: the scene guqin_fine needs them
#   HAPTICD_REMAKE_MODELS make the models of the scenes anew, to compare them with deploy/models: ALL or SOME, see deploy/make_models
set(HAPTICD_SANITIZE "" CACHE STRING "value of -fsanitize=")
set(HAPTICD_TEST_SCALE "0.1" CACHE STRING "default share of the full number of random trials in tests")
option(HAPTICD_FINE_MODELS "make the finest trees too" OFF)
set(HAPTICD_REMAKE_MODELS OFF CACHE STRING "make models of the scenes anew, to compare them: ALL or SOME")
option(HAPTICD_VM_TESTS "the tests in tests/vm" OFF)
option(HAPTICD_COVERAGE "instrument for gcov" OFF)
option(HAPTICD_WERROR "warnings are errors" OFF)
option(HAPTICD_HARDENED "guards in what is shipped" OFF)
option(HAPTICD_BENCHMARKS "build the benchmarks (needs google-benchmark)" OFF)
option(HAPTICD_UNITY "compile the sources of a target together, as far as their names allow" OFF)
option(HAPTICD_CHECK_HEADERS "compile every header on its own" ON)

# Meshes and trees of the scenes.
set(HAPTICD_SHIPPED_MODELS "${CMAKE_SOURCE_DIR}/deploy/models")
set(HAPTICD_MODELS_DIR "${HAPTICD_SHIPPED_MODELS}")
if(HAPTICD_FINE_MODELS)
  set(HAPTICD_MODELS_DIR "${CMAKE_BINARY_DIR}/models")
endif()

# Debian's own: a development machine may hide it behind another one.
set(HAPTICD_PYTHON /usr/bin/python3)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

find_program(HAPTICD_CCACHE ccache)
if(HAPTICD_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # What one clone of the project has compiled serves the others: paths below it count relative to it.
  set(CMAKE_CXX_COMPILER_LAUNCHER
    "${CMAKE_COMMAND}" -E env "CCACHE_BASEDIR=${CMAKE_SOURCE_DIR}" CCACHE_NOHASHDIR=1 "${HAPTICD_CCACHE}")
endif()
find_program(HAPTICD_MOLD mold)
if(HAPTICD_MOLD)
  add_link_options(-fuse-ld=mold)
endif()

# What tests/system/hardened.py looks for in the files.
set(HAPTICD_HARDENING -fstack-protector-strong -D_FORTIFY_SOURCE=3 -fstack-clash-protection)
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  list(APPEND HAPTICD_HARDENING -fcf-protection)
elseif(CMAKE_SYSTEM_PROCESSOR STREQUAL "aarch64")
  list(APPEND HAPTICD_HARDENING -mbranch-protection=standard)
endif()
set(HAPTICD_HARDENED_LINK -Wl,-z,relro -Wl,-z,now -Wl,-z,noexecstack)
if(HAPTICD_HARDENED)
  add_compile_options(${HAPTICD_HARDENING})
  add_link_options(${HAPTICD_HARDENED_LINK})
endif()

if(HAPTICD_SANITIZE)
  add_compile_options(-fsanitize=${HAPTICD_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${HAPTICD_SANITIZE})
  # No sanitizer of these sees a vector that was never set, as in Pose{q, {}}; NaN shows it.
  add_compile_definitions(EIGEN_INITIALIZE_MATRICES_BY_NAN)
endif()
if(HAPTICD_COVERAGE)
  add_compile_options(--coverage)
  add_link_options(--coverage)
endif()

# What every translation unit of ours must agree on, generated code included.
#   -ffp-contract=off      a fused multiply-add changes the last bit; results must not depend on compiler and CPU
#   -fno-math-errno        a square root is one instruction, without a call that sets errno; its value is the same
#   EIGEN_DONT_VECTORIZE   Eigen's packet paths change the order of reductions with -march
#   EIGEN_MAX_ALIGN_BYTES  0: size and alignment of Eigen members do not depend on -march
#   EIGEN_MPL2_ONLY        refuses Eigen's LGPL corners at compile time
add_library(hapticd_language INTERFACE)
target_include_directories(hapticd_language INTERFACE "${CMAKE_SOURCE_DIR}")
target_compile_options(hapticd_language INTERFACE -ffp-contract=off -fno-math-errno)
# gcc 12 fuses products with sums that alternate in sign all the same (vfmaddsub): it may not know of such instructions.
include(CheckCXXSourceCompiles)
unset(HAPTICD_GCC_MAY_FUSE CACHE)  # flags may have changed
check_cxx_source_compiles("#if !defined(__FMA__) || defined(__clang__)\n#error\n#endif\nint main() {}" HAPTICD_GCC_MAY_FUSE)
if(HAPTICD_GCC_MAY_FUSE)
  target_compile_options(hapticd_language INTERFACE -mno-fma)
endif()
target_compile_definitions(hapticd_language INTERFACE
  EIGEN_DONT_VECTORIZE EIGEN_MAX_ALIGN_BYTES=0 EIGEN_MPL2_ONLY)

# Warnings, for code written by hand. -Wdouble-promotion is left to gcc: clang's also refuses double to long double, which tests
# against long double are full of. Newer clangs call doctest's use of __COUNTER__ an extension. gcc 12 at -O3 warns of overlaps
# inside std::string that cannot be (its bug 105651).
add_library(hapticd_warnings INTERFACE)
target_compile_options(hapticd_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast
  -Wnon-virtual-dtor -Woverloaded-virtual -Wformat=2
  $<$<CXX_COMPILER_ID:GNU>:-Wdouble-promotion>
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict>
  $<$<AND:$<CXX_COMPILER_ID:Clang>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,20>>:-Wno-c2y-extensions>
  $<$<BOOL:${HAPTICD_WERROR}>:-Werror>)

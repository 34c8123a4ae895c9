# The commands a leaf folder's CMakeLists.txt uses. One folder is one target; files are listed by hand.
#
#   hapticd_library(core/math HEADERS pose.h SOURCES pose.cpp DEPENDS core/rt Eigen3::Eigen [REALTIME])
#       -> hapticd_core_math, static, or INTERFACE without SOURCES. REALTIME: no exceptions, symbols are checked.
#   hapticd_proto(proto PROTOS hapticd/v1/pose.proto ...)
#       -> hapticd_proto, static, from protoc; #include "hapticd/v1/pose.pb.h"
#   hapticd_program(hapticd bin)
#       -> the executable hapticd is installed into bin, and stands in bin of the build tree where it is that folder
#   hapticd_installed(TARGET ...)
#       -> the target `installed` builds these too. It makes all that is installed out of the build tree: deploy/play builds it, and
#          `cmake --install` works after it.
#   hapticd_test(core/math SOURCES pose_test.cpp DEPENDS core/math tests/support [LABELS unit] [REQUIRES broker])
#       -> test_core_math; every TEST_CASE is an entry of ctest. LABELS defaults to unit.
#   hapticd_command_test("tests/system/viewer: what it shows" LABELS system [REQUIRES page lab] COMMAND node live_test.js)
#       -> an entry of ctest that runs a command.
#       REQUIRES names groups of deploy/packages: where one is missing, the test is skipped and says how to get it. Any test is skipped
#       that ends with 77 and has printed "SKIPPED: reason".
#   hapticd_copies(copies FROM DIR TO DIR FILES src/a.js ...)
#       -> commands that copy files of the source tree, and copies, the list of what they make.
#   hapticd_benchmark(core/solver SOURCES qp_benchmark.cpp DEPENDS core/solver)
#       -> benchmark_core_solver, only with HAPTICD_BENCHMARKS
#   hapticd_fuzzer(proto SOURCES decode_fuzzer.cpp DEPENDS proto)
#       -> fuzz_proto, a libFuzzer executable, only in the preset fuzz
#
# A DEPENDS entry with '/' and without '::', or the word proto, is a folder of ours.
include_guard(GLOBAL)

# All that must exist before a tool such as clang-tidy can read the sources.
add_custom_target(generated_sources)

add_custom_target(installed)

function(hapticd_installed)
  add_dependencies(installed ${ARGN})
endfunction()

function(hapticd_copies out)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "FROM;TO" "FILES")
  set(copies "")
  foreach(file IN LISTS arg_FILES)
    add_custom_command(OUTPUT "${arg_TO}/${file}" DEPENDS "${arg_FROM}/${file}" VERBATIM
      COMMAND "${CMAKE_COMMAND}" -E copy "${arg_FROM}/${file}" "${arg_TO}/${file}")
    list(APPEND copies "${arg_TO}/${file}")
  endforeach()
  set(${out} "${copies}" PARENT_SCOPE)
endfunction()

function(hapticd_program target folder)
  if(folder STREQUAL "bin")
    set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
  endif()
  install(TARGETS ${target} RUNTIME DESTINATION ${folder})
  hapticd_installed(${target})
endfunction()

# What a folder installs belongs to one Debian package; hapticd_packages.cmake describes them. The component of install() has its name.
macro(hapticd_choose_package folder)
  set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME hapticd)
  if("${folder}" MATCHES "^(clients/lab|tests/oracle)$")
    set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME hapticd-lab)
  elseif("${folder}" STREQUAL "clients/python")
    set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME python3-hapticd)
  elseif("${folder}" MATCHES "^clients/(web|audio|osc|relay|play)")
    set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME hapticd-clients)
  elseif("${folder}" STREQUAL "clients/sdk")
    set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME libhapticd-client-dev)
  elseif("${folder}" STREQUAL "deploy/docs")
    set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME hapticd-doc)
  endif()
endmacro()

# core/math -> hapticd_core_math; Eigen3::Eigen and -lm stay as they are.
function(hapticd_resolve_depends out)
  set(targets "")
  foreach(entry IN LISTS ARGN)
    if(entry STREQUAL "proto" OR (entry MATCHES "/" AND NOT entry MATCHES "::"))
      string(REPLACE "/" "_" name "hapticd_${entry}")
      if(NOT TARGET ${name})
        message(FATAL_ERROR "${CMAKE_CURRENT_SOURCE_DIR}: no folder ${entry} before this one in HAPTICD_FOLDERS")
      endif()
      list(APPEND targets ${name})
    else()
      list(APPEND targets "${entry}")
    endif()
  endforeach()
  set(${out} "${targets}" PARENT_SCOPE)
endfunction()

# Every header compiles alone: NAME.h because NAME.cpp includes it first, and for each other a unit is generated that includes it.
function(hapticd_check_headers target folder)
  if(NOT HAPTICD_CHECK_HEADERS)
    return()
  endif()
  set(units "")
  foreach(header IN LISTS ARGN)
    cmake_path(REPLACE_EXTENSION header LAST_ONLY cpp OUTPUT_VARIABLE source)
    set(first "")
    if(EXISTS "${CMAKE_CURRENT_SOURCE_DIR}/${source}")
      file(STRINGS "${CMAKE_CURRENT_SOURCE_DIR}/${source}" first REGEX "^#include" LIMIT_COUNT 1)
    endif()
    if(first STREQUAL "#include \"${folder}/${header}\"")
      continue()
    endif()
    set(unit "${CMAKE_BINARY_DIR}/header_alone/${folder}/${header}.cpp")
    file(CONFIGURE OUTPUT "${unit}" CONTENT "#include \"${folder}/${header}\"\n#include \"${folder}/${header}\"\n")
    list(APPEND units "${unit}")
  endforeach()
  if(NOT units)
    return()
  endif()
  add_library(${target}_headers OBJECT ${units})
  target_link_libraries(${target}_headers PRIVATE ${target} hapticd_language hapticd_warnings)
  target_compile_options(${target}_headers PRIVATE -O0 -g0)
endfunction()

# Compiles the sources of a target in groups, with HAPTICD_UNITY. hapticd_group_sources, after all targets, says which.
function(hapticd_unity target)
  if(HAPTICD_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
    string(REPLACE ";" "\\;" line "${target};${CMAKE_CURRENT_SOURCE_DIR};${ARGN}")
    set_property(GLOBAL APPEND PROPERTY HAPTICD_UNITY_LINES "${line}")
  endif()
endfunction()

function(hapticd_group_sources)
  get_property(lines GLOBAL PROPERTY HAPTICD_UNITY_LINES)
  if(NOT lines)
    return()
  endif()
  list(JOIN lines "\n" text)
  file(WRITE "${CMAKE_BINARY_DIR}/unity_sources.txt" "${text}\n")
  execute_process(COMMAND "${HAPTICD_PYTHON}" -B "${CMAKE_SOURCE_DIR}/deploy/cmake/unity_groups.py" "${CMAKE_BINARY_DIR}/unity_groups.cmake"
    INPUT_FILE "${CMAKE_BINARY_DIR}/unity_sources.txt" WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}" COMMAND_ERROR_IS_FATAL ANY)
  include("${CMAKE_BINARY_DIR}/unity_groups.cmake")
endfunction()

function(hapticd_library folder)
  cmake_parse_arguments(PARSE_ARGV 1 arg "REALTIME" "" "HEADERS;SOURCES;DEPENDS")
  string(REPLACE "/" "_" target "hapticd_${folder}")
  hapticd_resolve_depends(depends ${arg_DEPENDS})
  if(arg_SOURCES)
    add_library(${target} STATIC ${arg_SOURCES})
    hapticd_unity(${target} ${arg_SOURCES})
    target_link_libraries(${target} PUBLIC hapticd_language ${depends} PRIVATE hapticd_warnings)
    if(arg_REALTIME)
      target_compile_options(${target} PRIVATE -fno-exceptions)
      set_property(GLOBAL APPEND PROPERTY HAPTICD_REALTIME_LIBRARIES ${target})
    endif()
  else()
    add_library(${target} INTERFACE)
    target_link_libraries(${target} INTERFACE hapticd_language ${depends})
  endif()
  hapticd_check_headers(${target} ${folder} ${arg_HEADERS})
endfunction()

function(hapticd_proto folder)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "PROTOS")
  set(generated "")
  foreach(proto IN LISTS arg_PROTOS)
    string(REGEX REPLACE "\\.proto$" ".pb" stem "${CMAKE_CURRENT_BINARY_DIR}/${proto}")
    add_custom_command(OUTPUT "${stem}.cc" "${stem}.h"
      COMMAND protobuf::protoc "--proto_path=${CMAKE_CURRENT_SOURCE_DIR}" "--cpp_out=${CMAKE_CURRENT_BINARY_DIR}" ${proto}
      DEPENDS ${arg_PROTOS} WORKING_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" VERBATIM)
    list(APPEND generated "${stem}.cc")
  endforeach()
  string(REPLACE "/" "_" target "hapticd_${folder}")
  add_custom_target(${target}_sources DEPENDS ${generated})
  add_dependencies(generated_sources ${target}_sources)
  add_library(${target} STATIC ${generated})
  add_dependencies(${target} ${target}_sources)
  target_include_directories(${target} SYSTEM PUBLIC "${CMAKE_CURRENT_BINARY_DIR}")
  target_link_libraries(${target} PUBLIC protobuf::libprotobuf)
endfunction()

# The words before a test's command, where it requires groups of packages.
function(hapticd_with_groups out)
  set(${out} "" PARENT_SCOPE)
  if(ARGN)
    list(JOIN ARGN "," groups)
    set(${out} "${CMAKE_SOURCE_DIR}/deploy/cmake/with_groups" ${groups} PARENT_SCOPE)
  endif()
endfunction()

function(hapticd_command_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "LABELS;REQUIRES;COMMAND")
  hapticd_with_groups(with_groups ${arg_REQUIRES})
  add_test(NAME "${name}" COMMAND ${with_groups} ${arg_COMMAND})
  set_tests_properties("${name}" PROPERTIES LABELS "${arg_LABELS}" SKIP_RETURN_CODE 77)
endfunction()

function(hapticd_test folder)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS;LABELS;REQUIRES")
  if(NOT arg_LABELS)
    set(arg_LABELS unit)
  endif()
  string(REPLACE "/" "_" target "test_${folder}")
  hapticd_resolve_depends(depends ${arg_DEPENDS} tests/support)
  add_executable(${target} ${arg_SOURCES})
  hapticd_unity(${target} ${arg_SOURCES})
  target_link_libraries(${target} PRIVATE hapticd_warnings ${depends} hapticd_doctest_main)

  # The executable lists its own cases after each build; ctest includes the list.
  hapticd_with_groups(with_groups ${arg_REQUIRES})
  set(list_file "${CMAKE_CURRENT_BINARY_DIR}/${target}_cases.cmake")
  add_custom_command(TARGET ${target} POST_BUILD BYPRODUCTS "${list_file}" VERBATIM
    COMMAND "${HAPTICD_PYTHON}" "${CMAKE_SOURCE_DIR}/deploy/cmake/list_test_cases.py"
      $<TARGET_FILE:${target}> ${folder} "${arg_LABELS}" "${list_file}" ${with_groups})
  set(include_file "${CMAKE_CURRENT_BINARY_DIR}/${target}_include.cmake")
  file(WRITE "${include_file}"
    "if(EXISTS \"${list_file}\")\n  include(\"${list_file}\")\nelse()\n  add_test(\"${folder}: not built\" not_built)\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES "${include_file}")
endfunction()

function(hapticd_benchmark folder)
  if(NOT HAPTICD_BENCHMARKS)
    return()
  endif()
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS")
  find_package(benchmark REQUIRED)
  string(REPLACE "/" "_" target "benchmark_${folder}")
  hapticd_resolve_depends(depends ${arg_DEPENDS})
  add_executable(${target} ${arg_SOURCES})
  target_link_libraries(${target} PRIVATE hapticd_warnings ${depends} benchmark::benchmark_main)
endfunction()

function(hapticd_fuzzer folder)
  if(NOT HAPTICD_SANITIZE MATCHES "fuzzer")
    return()
  endif()
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS")
  string(REPLACE "/" "_" target "fuzz_${folder}")
  hapticd_resolve_depends(depends ${arg_DEPENDS})
  add_executable(${target} ${arg_SOURCES})
  target_link_libraries(${target} PRIVATE hapticd_warnings ${depends} -fsanitize=fuzzer)
  if(NOT TARGET fuzzers)
    add_custom_target(fuzzers)
  endif()
  add_dependencies(fuzzers ${target})
endfunction()

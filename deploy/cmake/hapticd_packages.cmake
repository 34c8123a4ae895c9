# The Debian packages, one for each component of install(), which hapticd_choose_package names. deploy/package builds them with CPack.
# What only Debian needs is added by finish_packages.cmake when CPack has installed a component: copyright, changelog, pages compressed.
# trim_packages.cmake takes out what Debian does not want.
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL hapticd hapticd-clients hapticd-lab python3-hapticd hapticd-doc libhapticd-client0 libhapticd-client-dev)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_SET_DESTDIR ON) # the udev rules name their program by its place
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}")
set(CPACK_PACKAGE_VENDOR hapticd)
set(CPACK_PACKAGE_DIRECTORY "${CMAKE_BINARY_DIR}/packages")
set(CPACK_PRE_BUILD_SCRIPTS "${CMAKE_CURRENT_LIST_DIR}/finish_packages.cmake")
set(CPACK_POST_BUILD_SCRIPTS "${CMAKE_CURRENT_LIST_DIR}/trim_packages.cmake")
set(CPACK_HAPTICD_SOURCE "${CMAKE_SOURCE_DIR}") # for finish_packages.cmake
set(CPACK_VERBATIM_VARIABLES ON)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SOURCE hapticd)
# A name that no mail can reach: the authors have no address.
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "The hapticd authors <hapticd@example.org>")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# hapticd_package(NAME "synopsis" "description" [SECTION name] [SCRIPTS folder] [ALL] [DEPENDS ...] [RECOMMENDS ...] [SUGGESTS ...])
#   ALL: the same on every architecture. SCRIPTS: the folder of deploy/debian with its maintainer scripts and other control files. Those
#   that end in .in are configured.
macro(hapticd_package name synopsis description)
  cmake_parse_arguments(package "ALL" "SECTION;SCRIPTS" "DEPENDS;RECOMMENDS;SUGGESTS" ${ARGN})
  string(TOUPPER "${name}" prefix)
  set(prefix "CPACK_DEBIAN_${prefix}")
  set(${prefix}_PACKAGE_NAME "${name}")
  set(${prefix}_DESCRIPTION "${synopsis}\n${description}")
  if(package_SECTION)
    set(${prefix}_PACKAGE_SECTION "${package_SECTION}")
  endif()
  if(package_ALL)
    set(${prefix}_PACKAGE_ARCHITECTURE all)
  else()
    set(${prefix}_PACKAGE_SHLIBDEPS ON)
  endif()
  foreach(relation DEPENDS RECOMMENDS SUGGESTS)
    list(JOIN package_${relation} ", " ${prefix}_PACKAGE_${relation})
  endforeach()
  if(package_SCRIPTS)
    file(GLOB ${prefix}_PACKAGE_CONTROL_EXTRA "${CMAKE_SOURCE_DIR}/deploy/debian/${package_SCRIPTS}/*")
    foreach(template IN LISTS ${prefix}_PACKAGE_CONTROL_EXTRA)
      if(template MATCHES "([^/]+)\\.in$")
        set(control "${CMAKE_BINARY_DIR}/debian/${name}/${CMAKE_MATCH_1}")
        configure_file("${template}" "${control}" @ONLY)
        list(TRANSFORM ${prefix}_PACKAGE_CONTROL_EXTRA REPLACE "^${template}$" "${control}")
      endif()
    endforeach()
  endif()
endmacro()

set(same "(= ${PROJECT_VERSION})")

hapticd_package(hapticd "daemon for haptic rendering with six degrees of freedom"
"hapticd computes forces and torques for a haptic device a thousand times a
second. It keeps a virtual hand outside of everything that it touches, at any
speed, and pushes back. Bodies are rigid; strings bend, slip off the finger
and ring. It needs no display: pictures and sound are made by clients that
subscribe to its stream.
.
This package has the daemon, hapticctl to control it from a terminal, and
hapticd-model to make sphere-trees for scenes of one's own; scenes, gestures
and device profiles; the udev rule that gives devices to the group hapticd;
and a service for systemd, which is not started unless asked for."
  SCRIPTS hapticd
  DEPENDS "systemd | systemd-standalone-sysusers | systemd-sysusers"
  RECOMMENDS hapticd-clients
  SUGGESTS avahi-daemon hapticd-doc)

hapticd_package(hapticd-clients "viewer, sound and bridges for the haptic daemon hapticd"
"hapticd computes forces for a haptic device. These programs subscribe to what
it plays: haptic-web shows it in a browser, haptic-audio makes it heard by
JACK or PipeWire, haptic-osc and haptic-relay send it on by OSC and MQTT.
.
hapticd-play starts the daemon, the viewer and the sound with one command."
  SCRIPTS clients
  DEPENDS "hapticd ${same}"
  RECOMMENDS "pipewire-jack | jackd2")

hapticd_package(hapticd-lab "experiments and figures with the haptic daemon hapticd"
"hapticd computes forces for a haptic device. hapticd-lab plays sessions with
it, measures and plots them: it reproduces the figures of the paper that
hapticd began with, runs its experiment with a person at a device, and fits
strings to measured forces. hapticd-oracle judges a session by exhaustive
search and closed forms."
  SCRIPTS python
  DEPENDS "hapticd ${same}" "python3-hapticd ${same}" python3 python3-cryptography python3-jinja2 python3-matplotlib python3-numpy python3-protobuf
    python3-scipy
  SUGGESTS "hapticd-clients" chromium ffmpeg valgrind)

hapticd_package(python3-hapticd "Python client of the haptic daemon hapticd"
"hapticd computes forces for a haptic device. With this package a Python
script controls it and reads its stream of states and events, or steps it tick
by tick in virtual time."
  ALL
  SECTION python
  SCRIPTS python
  DEPENDS python3 "python3-protobuf (>= 3.21)"
  RECOMMENDS python3-cryptography
  SUGGESTS hapticd python3-numpy python3-pandas python3-xarray)

hapticd_package(hapticd-doc "documentation of the haptic daemon hapticd"
"hapticd computes forces for a haptic device. This package has its pages: how
it is used and how it works, what has been measured, the protocol with its
message definitions, and examples of clients. All of it is also a site with
search, for a browser: /usr/share/doc/hapticd/html/index.html."
  ALL
  SECTION doc
  DEPENDS "libjs-sphinxdoc (>= 5.2)")

hapticd_package(libhapticd-client0 "library for clients of the haptic daemon hapticd"
"hapticd computes forces for a haptic device. Programs that control it, step it
or follow what it plays use this library, by its C++ or its C interface."
  SECTION libs
  SCRIPTS libhapticd-client0
  SUGGESTS hapticd)

hapticd_package(libhapticd-client-dev "headers to write clients of the haptic daemon hapticd"
"hapticd computes forces for a haptic device. With this package programs in C++
and C, and in languages that can call C, are built that control it, step it or
follow what it plays: headers, the static library, files for CMake and
pkg-config, the protocol and its message definitions."
  SECTION libdevel
  DEPENDS "libhapticd-client0 ${same}" libprotobuf-dev libsodium-dev zlib1g-dev
  SUGGESTS hapticd hapticd-doc)

include(CPack)

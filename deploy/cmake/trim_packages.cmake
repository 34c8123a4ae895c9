# Run by CPack when the packages are there. Takes out the scripts that CPack gives every package with a shared library: they call ldconfig,
# for which Debian has the trigger of deploy/debian/libhapticd-client0. Needs dpkg-deb.
cmake_minimum_required(VERSION 3.25)

foreach(package IN LISTS CPACK_PACKAGE_FILES)
  if(package MATCHES "/libhapticd-client0_")
    set(folder "${package}.unpacked")
    execute_process(COMMAND dpkg-deb --raw-extract "${package}" "${folder}" COMMAND_ERROR_IS_FATAL ANY)
    file(REMOVE "${folder}/DEBIAN/postinst" "${folder}/DEBIAN/postrm")
    execute_process(COMMAND dpkg-deb --root-owner-group -Zxz --build "${folder}" "${package}" OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
    file(REMOVE_RECURSE "${folder}")
  endif()
endforeach()

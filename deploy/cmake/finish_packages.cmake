# Run by CPack between installing the components and packing them: adds what Debian asks of every package. Needs gzip and python3.
cmake_minimum_required(VERSION 3.25)

unset(ENV{DESTDIR}) # file(INSTALL) would put it before its own
set(debian "${CPACK_HAPTICD_SOURCE}/deploy/debian")
foreach(package IN LISTS CPACK_COMPONENTS_ALL)
  set(usr "${CPACK_TEMPORARY_INSTALL_DIRECTORY}/${package}/usr")
  set(doc "${usr}/share/doc/${package}")
  file(INSTALL "${debian}/copyright" DESTINATION "${doc}")
  execute_process(COMMAND /usr/bin/python3 -B "${CPACK_HAPTICD_SOURCE}/deploy/cmake/debian_changelog.py" "${CPACK_HAPTICD_SOURCE}/CHANGELOG.md"
    "${CPACK_PACKAGE_VERSION}" "${CPACK_DEBIAN_PACKAGE_MAINTAINER}" OUTPUT_FILE "${doc}/changelog" COMMAND_ERROR_IS_FATAL ANY)
  file(GLOB pages "${usr}/share/man/man*/*.[1-9]")
  execute_process(COMMAND gzip -9n "${doc}/changelog" ${pages} COMMAND_ERROR_IS_FATAL ANY)
endforeach()

# The site's scripts that Debian has in a package of its own, which hapticd-doc depends on.
set(scripts /usr/share/javascript/sphinxdoc/1.0)
set(site "${CPACK_TEMPORARY_INSTALL_DIRECTORY}/hapticd-doc/usr/share/doc/hapticd/html/_static")
foreach(script jquery.js underscore.js _sphinx_javascript_frameworks_compat.js doctools.js searchtools.js language_data.js sphinx_highlight.js)
  if(EXISTS "${site}/${script}" AND EXISTS "${scripts}/${script}")
    file(REMOVE "${site}/${script}")
    file(CREATE_LINK "../../../../javascript/sphinxdoc/1.0/${script}" "${site}/${script}" SYMBOLIC)
  endif()
endforeach()

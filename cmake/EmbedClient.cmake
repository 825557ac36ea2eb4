# Builds the planner's page (web/, npm and Vite) and makes it part of the program. Without npm the
# program still builds and serves a page that says what is missing.
#   in: npm on PATH    out: client_sources
enable_language(ASM)
set(client_sources ${CMAKE_BINARY_DIR}/generated/client_files.cpp
                   ${CMAKE_BINARY_DIR}/generated/client_files.S)
set(web ${CMAKE_SOURCE_DIR}/web)
set(embed -DOUT=${CMAKE_BINARY_DIR}/generated -P ${CMAKE_SOURCE_DIR}/cmake/write_client_files.cmake)

find_program(NPM_PROGRAM npm)
if(NPM_PROGRAM)
  file(GLOB_RECURSE web_files CONFIGURE_DEPENDS ${web}/src/* ${web}/public/*)
  list(APPEND web_files ${web}/index.html ${web}/package.json ${web}/package-lock.json
       ${web}/vite.config.ts ${web}/tsconfig.json)
  set(installed ${web}/node_modules/.package-lock.json)
  add_custom_command(OUTPUT ${installed}
    COMMAND ${NPM_PROGRAM} ci --no-audit --no-fund --loglevel=error
    COMMAND ${CMAKE_COMMAND} -E touch ${installed}
    DEPENDS ${web}/package-lock.json WORKING_DIRECTORY ${web}
    COMMENT "Installing the packages of the planner's page" VERBATIM)
  add_custom_command(OUTPUT ${client_sources}
    COMMAND ${NPM_PROGRAM} run --silent build -- --logLevel warn --outDir ${CMAKE_BINARY_DIR}/client --emptyOutDir
    COMMAND ${CMAKE_COMMAND} -DCLIENT=${CMAKE_BINARY_DIR}/client ${embed}
    DEPENDS ${installed} ${web_files} ${CMAKE_SOURCE_DIR}/cmake/write_client_files.cmake
    WORKING_DIRECTORY ${web} COMMENT "Building the planner's page" VERBATIM)
else()
  message(STATUS "npm not found: the planner's page is left out (apt-get install nodejs npm)")
  add_custom_command(OUTPUT ${client_sources} COMMAND ${CMAKE_COMMAND} -DCLIENT=${CMAKE_SOURCE_DIR}/web/without ${embed}
    DEPENDS ${CMAKE_SOURCE_DIR}/web/without/index.html ${CMAKE_SOURCE_DIR}/cmake/write_client_files.cmake VERBATIM)
endif()

# How every target of this project is compiled.

# udar_own_code(TARGET [OPEN]): our warnings, sanitizers and processor flags, none of which a user of the library
# inherits. OPEN: whoever loads it has symbols that it needs.
function(udar_own_code target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow
                                           -ffile-prefix-map=${PROJECT_SOURCE_DIR}/=)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # False alarms on "text" + std::string: gcc.gnu.org/PR105651, fixed in 13.
    target_compile_options(${target} PRIVATE -Wno-restrict)
  endif()
  if(UDAR_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(UDAR_NATIVE)
    target_compile_options(${target} PRIVATE -march=native)
  endif()
  if(UDAR_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${UDAR_SANITIZE} -fno-sanitize-recover=all
                                             -fno-omit-frame-pointer)
    if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
      # It takes a reference to a vector of numbers that may stand anywhere for one to an aligned vector, and reports
      # it, as in network/junction_system.cpp.
      target_compile_options(${target} PRIVATE -fno-sanitize=alignment)
    endif()
    target_link_options(${target} PRIVATE -fsanitize=${UDAR_SANITIZE})
  elseif(NOT "OPEN" IN_LIST ARGN)
    target_link_options(${target} PRIVATE LINKER:--no-undefined)
  endif()
endfunction()

# udar_add_program(TARGET FILE SOURCE...): an installed program FILE, in the build folder itself.
function(udar_add_program target file)
  add_executable(${target} ${ARGN} ${PROJECT_SOURCE_DIR}/src/preinit.cpp)
  udar_own_code(${target})
  target_link_libraries(${target} PRIVATE udar::udar nlohmann_json::nlohmann_json)
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${file} RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
  install(TARGETS ${target})
endfunction()

# udar_add_python_program(FILE SOURCE): a script in the build folder, for the Python that was found to have its modules.
function(udar_add_python_program file source)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
  file(READ ${source} text)
  if(UDAR_PYTHON)
    string(REGEX REPLACE "^#![^\n]*" "#!${UDAR_PYTHON}" text "${text}")
  endif()
  set(path ${PROJECT_BINARY_DIR}/${file})
  file(WRITE ${path} "${text}")
  file(CHMOD ${path} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  install(PROGRAMS ${path} DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()

# udar_add_python_package(FOLDER): a package, in `python` of the build folder and where Debian's Python looks for it.
set(UDAR_PYTHON_DIR lib/python3/dist-packages CACHE STRING "Where Python modules are installed, below the prefix")
function(udar_add_python_package folder)
  set(patterns *.py *.pyi *.js *.css *.html *.md LICENSE.* py.typed)
  list(TRANSFORM patterns PREPEND ${folder}/)
  file(GLOB_RECURSE files CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}/${folder} ${patterns})
  cmake_path(GET folder FILENAME name)
  foreach(file IN LISTS files)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/${file})
    cmake_path(GET file PARENT_PATH inside)
    file(COPY ${folder}/${file} DESTINATION ${PROJECT_BINARY_DIR}/python/${name}/${inside})
    install(FILES ${folder}/${file} DESTINATION ${UDAR_PYTHON_DIR}/${name}/${inside})
  endforeach()
endfunction()

# udar_add_python_module(SOURCES PACKAGE): the extension _core of a package, beside it in the build folder and where it
# is installed, for the Python that was found. Sanitized there is none, for that Python could not load it.
option(UDAR_PYTHON_MODULE "Build udar.core where pybind11 and Python's headers are found" ON)
function(udar_add_python_module sources folder)
  if(NOT UDAR_PYTHON OR NOT UDAR_PYTHON_MODULE OR UDAR_SANITIZE)
    return()
  endif()
  set(Python_EXECUTABLE ${UDAR_PYTHON})
  find_package(Python 3 QUIET COMPONENTS Interpreter Development.Module)
  find_package(pybind11 2.10 CONFIG QUIET)
  if(NOT Python_Development.Module_FOUND OR NOT pybind11_FOUND)
    message(STATUS "no udar.core: it needs pybind11 and Python's headers (Debian: pybind11-dev, python3-dev)")
    return()
  endif()
  cmake_path(GET folder FILENAME package)
  file(GLOB files CONFIGURE_DEPENDS ${sources}/*.cpp)
  pybind11_add_module(udar_python MODULE NO_EXTRAS ${files})
  udar_own_code(udar_python OPEN)
  target_include_directories(udar_python PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(udar_python PRIVATE udar::udar ${CMAKE_DL_LIBS})
  cmake_path(SET inside NORMALIZE ${CMAKE_INSTALL_PREFIX}/${UDAR_PYTHON_DIR}/${package})
  file(RELATIVE_PATH library_from_module ${inside} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_target_properties(udar_python PROPERTIES OUTPUT_NAME _core LIBRARY_OUTPUT_DIRECTORY
                                               ${PROJECT_BINARY_DIR}/python/${package}
                                               INSTALL_RPATH "$ORIGIN/${library_from_module}")
  install(TARGETS udar_python LIBRARY DESTINATION ${UDAR_PYTHON_DIR}/${package})
endfunction()

# udar_add_manual(PROGRAM_TARGET...): manual pages and completions of bash, zsh and fish, made of what the programs say
# under -help, those in Python included.
set(UDAR_ZSH_DIR ${CMAKE_INSTALL_DATADIR}/zsh/site-functions
    CACHE STRING "Where zsh looks for completions, below the prefix")
function(udar_add_manual)
  if(NOT UDAR_PYTHON OR (CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR))
    message(STATUS "no manual pages and completions: they need a Python, and programs that run here")
    return()
  endif()
  set(maker ${PROJECT_SOURCE_DIR}/scripts/manual-pages)
  set(made ${PROJECT_BINARY_DIR}/manual)
  file(GLOB parts CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/scripts/manual/*.py)
  file(GLOB_RECURSE package CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/scripts/python/udar/*cli.py)
  add_custom_command(
    OUTPUT ${made}/stamp
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${made}
    COMMAND ${CMAKE_COMMAND} -E env PYTHONDONTWRITEBYTECODE=1 ${UDAR_PYTHON} ${maker} ${PROJECT_BINARY_DIR} ${made}
            ${PROJECT_VERSION}
    COMMAND ${CMAKE_COMMAND} -E touch ${made}/stamp
    DEPENDS ${ARGN} ${maker} ${parts} ${package}
    COMMENT "Making manual pages and completions"
    VERBATIM)
  add_custom_target(udar_manual ALL DEPENDS ${made}/stamp)
  install(DIRECTORY ${made}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR})
  install(DIRECTORY ${made}/bash/ DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
  install(DIRECTORY ${made}/zsh/ DESTINATION ${UDAR_ZSH_DIR})
  install(DIRECTORY ${made}/fish/ DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
endfunction()

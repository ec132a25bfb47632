# Writes the commit that the sources are at into a header, empty where nobody knows it; left alone if nothing changed.
# usage: cmake -D SOURCE=folder -D HEADER=file -P udar_revision.cmake
execute_process(
  COMMAND git -C ${SOURCE} describe --always --dirty --exclude=*
  OUTPUT_VARIABLE revision
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET
  RESULT_VARIABLE failed)
if(failed OR NOT EXISTS ${SOURCE}/.git) # of another project around these sources
  set(revision "")
endif()
file(CONFIGURE OUTPUT ${HEADER} @ONLY
     CONTENT [[
#pragma once

namespace udar {

inline constexpr const char* kRevision = "@revision@";  ///< commit of the sources; empty: unknown

}  // namespace udar
]])

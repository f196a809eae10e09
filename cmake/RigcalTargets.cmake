include(GoogleTest)

add_library(rigcal_options INTERFACE)
# Debian's Ceres is built for plain x86-64. Eigen's allocation must not depend on our wider -march, or memory that crosses
# the border is freed by the wrong scheme.
target_compile_definitions(rigcal_options INTERFACE EIGEN_MAX_ALIGN_BYTES=16)
target_compile_options(rigcal_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  -Wno-missing-field-initializers)  # designated initialisers name what they set; the rest has its default
target_include_directories(rigcal_options INTERFACE ${CMAKE_SOURCE_DIR})
if(RIGCAL_WARNINGS_AS_ERRORS)
  target_compile_options(rigcal_options INTERFACE -Werror)
endif()
if(RIGCAL_ARCH AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_compile_options(rigcal_options INTERFACE -march=${RIGCAL_ARCH})
endif()
if(RIGCAL_SANITIZE)
  # g++ 12 at -O1 with sanitizers takes parts of std::regex for uninitialised.
  target_compile_options(rigcal_options INTERFACE -fsanitize=${RIGCAL_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer
    -Wno-maybe-uninitialized)
  target_link_options(rigcal_options INTERFACE -fsanitize=${RIGCAL_SANITIZE})
endif()

# rigcal_library(NAME [LINKS ...]): every .cpp of the current folder as a static library. Libraries of others are system
# headers: their warnings are not ours.
function(rigcal_library name)
  cmake_parse_arguments(ARG "" "" "LINKS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  if(sources)
    add_library(${name} STATIC ${sources})
    target_link_libraries(${name} PUBLIC rigcal_options ${ARG_LINKS})
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE rigcal_options ${ARG_LINKS})
  endif()
endfunction()

# rigcal_test(NAME [LINKS ...] [LABELS ...] [TIMEOUT s] [UNDER program]): every *_test.cpp of the current folder as one
# program; each TEST is a ctest, run by the program UNDER where that is given.
function(rigcal_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT;UNDER" "LINKS;LABELS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*_test.cpp)
  if(NOT sources)
    return()
  endif()
  add_executable(${name} ${sources})
  target_link_libraries(${name} PRIVATE rigcal_options rigcal_test_support ${ARG_LINKS} GTest::gmock GTest::gtest GTest::gtest_main)
  if(ARG_UNDER AND NOT RIGCAL_SANITIZE)  # what is preloaded would come before the sanitizer
    set_target_properties(${name} PROPERTIES CROSSCOMPILING_EMULATOR ${ARG_UNDER})
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 600)
  endif()
  set(properties TIMEOUT ${ARG_TIMEOUT})
  if(ARG_LABELS)
    list(APPEND properties LABELS "${ARG_LABELS}")
  endif()
  # Parameters are told by their index: printed as bytes they hold addresses.
  gtest_discover_tests(${name} NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60 PROPERTIES ${properties})
endfunction()

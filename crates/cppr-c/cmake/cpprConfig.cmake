# find_package(cppr): cppr::cppr, the shared library, and cppr::static. Where it stands is found from this file, so that the whole
# folder may be moved.
get_filename_component(_cppr_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
set(_cppr_lib "${_cppr_prefix}/lib/${CMAKE_LIBRARY_ARCHITECTURE}" "${_cppr_prefix}/lib" "${_cppr_prefix}/lib64")
find_path(cppr_INCLUDE_DIR cppr.h PATHS "${_cppr_prefix}/include" NO_DEFAULT_PATH)
find_library(cppr_LIBRARY cppr PATHS ${_cppr_lib} NO_DEFAULT_PATH)
find_file(cppr_STATIC_LIBRARY libcppr.a PATHS ${_cppr_lib} NO_DEFAULT_PATH)
mark_as_advanced(cppr_INCLUDE_DIR cppr_LIBRARY cppr_STATIC_LIBRARY)
find_package(Threads)

foreach(_cppr_target IN ITEMS cppr static)
    if(_cppr_target STREQUAL "cppr")
        set(_cppr_kind SHARED)
        set(_cppr_file "${cppr_LIBRARY}")
    else()
        set(_cppr_kind STATIC)
        set(_cppr_file "${cppr_STATIC_LIBRARY}")
    endif()
    if(_cppr_file AND cppr_INCLUDE_DIR AND NOT TARGET cppr::${_cppr_target})
        add_library(cppr::${_cppr_target} ${_cppr_kind} IMPORTED)
        set_target_properties(cppr::${_cppr_target} PROPERTIES
            IMPORTED_LOCATION "${_cppr_file}"
            INTERFACE_INCLUDE_DIRECTORIES "${cppr_INCLUDE_DIR}"
            INTERFACE_COMPILE_FEATURES cxx_std_17)
        if(_cppr_kind STREQUAL "STATIC")
            set_target_properties(cppr::static PROPERTIES
                INTERFACE_LINK_LIBRARIES "Threads::Threads;${CMAKE_DL_LIBS};$<$<PLATFORM_ID:Linux>:m>")
        endif()
    endif()
endforeach()

if(NOT TARGET cppr::cppr)
    set(cppr_FOUND FALSE)
    set(cppr_NOT_FOUND_MESSAGE "neither ${_cppr_prefix}/include/cppr.h nor its library in ${_cppr_prefix}/lib may be missing")
endif()

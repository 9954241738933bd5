# SPDX-License-Identifier: MIT
# nf_header_only(<target> <entry> [<folder of the include directory>])
#
# A library of the PC whose headers alone are used. Its folder is linked into one of ours: beside it lie the headers of the
# PC's C library, which a browser does not have.
function(nf_header_only target entry)
    find_path(NF_${entry}_ROOT ${entry} PATHS /usr/include ${ARGN} NO_DEFAULT_PATH NO_CMAKE_FIND_ROOT_PATH)
    if(NOT NF_${entry}_ROOT)
        message(FATAL_ERROR "There is no header folder ${entry}. Run `tools/dev setup`.")
    endif()
    set(folder ${CMAKE_BINARY_DIR}/libraries/${entry})
    file(MAKE_DIRECTORY ${folder})
    file(CREATE_LINK ${NF_${entry}_ROOT}/${entry} ${folder}/${entry} SYMBOLIC)
    if(NOT TARGET ${target})
        add_library(${target} INTERFACE IMPORTED GLOBAL)
        set_target_properties(${target} PROPERTIES INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${folder}
            INTERFACE_INCLUDE_DIRECTORIES ${folder})
    endif()
endfunction()

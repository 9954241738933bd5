# SPDX-License-Identifier: MIT
# Libraries of the PC whose headers alone are used. The folder of such a library is linked into one of ours: beside it lie
# the headers of the PC's C library, which a browser does not have.

# nf_header_folder(<entry> <name> [<folder of the include directory>])
#
# NF_<name>_FOLDER is the include folder that has `entry` alone.
function(nf_header_folder entry name)
    find_path(NF_${name}_ROOT ${entry} PATHS /usr/include ${ARGN} NO_DEFAULT_PATH NO_CMAKE_FIND_ROOT_PATH)
    if(NOT NF_${name}_ROOT)
        message(FATAL_ERROR "There is no header folder ${entry}. Run `tools/dev setup`.")
    endif()
    set(folder ${CMAKE_BINARY_DIR}/libraries/${name})
    file(MAKE_DIRECTORY ${folder})
    file(CREATE_LINK ${NF_${name}_ROOT}/${entry} ${folder}/${entry} SYMBOLIC)
    set(NF_${name}_FOLDER ${folder} PARENT_SCOPE)
endfunction()

# nf_header_only(<target> <entry> [<folder of the include directory>])
function(nf_header_only target entry)
    nf_header_folder(${entry} ${entry} ${ARGN})
    if(NOT TARGET ${target})
        add_library(${target} INTERFACE IMPORTED GLOBAL)
        set_target_properties(${target} PROPERTIES INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${NF_${entry}_FOLDER}
            INTERFACE_INCLUDE_DIRECTORIES ${NF_${entry}_FOLDER})
    endif()
endfunction()

# SPDX-License-Identifier: MIT
# Completion of ectwin for fish. The words come from the program itself: `ectwin complete`; without one, files are offered.
function __ectwin_complete
    set -l words (commandline -opc) (commandline -ct)
    set -l candidates ($words[1] complete $words[2..-1] 2>/dev/null)
    if set -q candidates[1]
        printf '%s\n' $candidates
    else
        __fish_complete_path (commandline -ct)
    end
end
complete -c ectwin -f -a '(__ectwin_complete)'

# SPDX-License-Identifier: MIT
# Completion of ectwin for fish. The words come from the program itself: `ectwin complete`.
function __ectwin_complete
    set -l words (commandline -opc) (commandline -ct)
    $words[1] complete $words[2..-1] 2>/dev/null
end
complete -c ectwin -a '(__ectwin_complete)'

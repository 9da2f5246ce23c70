# SPDX-License-Identifier: MIT
# Completion of ectwin for bash, and for zsh by bashcompinit. The words come from the program itself: `ectwin complete`.

_ectwin()
{
  local IFS=$'\n' word=${COMP_WORDS[COMP_CWORD]}
  # readline splits words at these: what stands before the last of them is on the line already
  local line=${COMP_LINE:0:COMP_POINT}
  local typed=${line##* }
  local candidates
  mapfile -t candidates < <("${COMP_WORDS[0]}" complete "${COMP_WORDS[@]:1:COMP_CWORD-1}" "$typed" 2>/dev/null)
  COMPREPLY=("${candidates[@]#"${typed%"$word"}"}")
  case ${COMPREPLY[0]-} in
    *= | *,) compopt -o nospace ;;
  esac
  [ ${#COMPREPLY[@]} -gt 0 ] || compopt -o default
}

complete -F _ectwin ectwin

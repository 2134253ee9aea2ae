_repro() {
    local -a found
    found=("${(@f)$(repro completion --line "${BUFFER[1,CURSOR]}" 2>/dev/null)}")
    [[ -n $found ]] && compadd -Q -S '' -- $found || _files
}
compdef _repro repro

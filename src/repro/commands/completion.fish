complete -c repro -a '(repro completion --line (commandline -cp) 2>/dev/null)'

#!/bin/sh
# Focuses the camera when its images are blurred.
focus='{"kind":"set_parameter","node":"camera","name":"perform_autofocus","value":true}'
read -r system
while read -r line; do
    case $line in
    *'"camera_autofocus_needed":true'*) echo "{\"adaptations\":[$focus]}" ;;
    *) echo '{}' ;;
    esac
done

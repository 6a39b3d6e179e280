/PROG  KR_270_M
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "elastocal";
PROG_SIZE	= 0;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 108;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  !Calibration campaign: 4 ;
   2:  !experiments in 3 configurations. ;
   3:  !Made by elastocal 0.1.0 from 'KR ;
   4:  !270 milling cell', plan sha256 ;
   5:  !0123456789abcdef. ;
   6:  !Robot: kuka-kr270. Joint values: ;
   7:  !deg, mm, as in the model. ;
   8:  !Forces act at the load point of ;
   9:  !the tool, in the axes of the ;
  10:  !robot base. ;
  11:  !No home position: the first ;
  12:  !motion starts where the robot ;
  13:  !stands. ;
  14:  !SAFETY: check this program at ;
  15:  !low speed in manual mode first. ;
  16:  !Motions between the points are ;
  17:  !not checked for collisions by ;
  18:  !this file. ;
  19:  !Set the payload of the empty ;
  20:  !calibration tool and leave it ;
  21:  !so, loaded and unloaded: the ;
  22:  !controller must not compensate ;
  23:  !what is to be measured. ;
  24:  !elastocal program 000000000000 ;
  25:  UFRAME_NUM=0 ;
  26:  UTOOL_NUM=1 ;
  27:  !to AP1 ;
  28:J P[1] 10% FINE    ;
  29:  !to P1 ;
  30:J P[2] 10% FINE    ;
  31:  WAIT   2.00(sec) ;
  32:  MESSAGE[Experiment 1/4: pose 1.] ;
  33:  MESSAGE[NO load. Measure M1.] ;
  34:  PAUSE ;
  35:  MESSAGE[Experiment 1/4: hang] ;
  36:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  37:  MESSAGE[-2500 N.] ;
  38:  PAUSE ;
  39:  WAIT   2.00(sec) ;
  40:  MESSAGE[Experiment 1/4: pose 1.] ;
  41:  MESSAGE[LOADED. Measure M1.] ;
  42:  PAUSE ;
  43:  MESSAGE[Experiment 1/4: take the] ;
  44:  MESSAGE[load off. The robot] ;
  45:  MESSAGE[moves next.] ;
  46:  PAUSE ;
  47:  !to AP1 ;
  48:J P[1] 10% FINE    ;
  49:  !to P1 ;
  50:J P[2] 10% FINE    ;
  51:  WAIT   2.00(sec) ;
  52:  MESSAGE[Experiment 2/4: pose 1.] ;
  53:  MESSAGE[NO load. Measure M1.] ;
  54:  PAUSE ;
  55:  MESSAGE[Experiment 2/4: hang] ;
  56:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  57:  MESSAGE[-2500 N.] ;
  58:  PAUSE ;
  59:  WAIT   2.00(sec) ;
  60:  MESSAGE[Experiment 2/4: pose 1.] ;
  61:  MESSAGE[LOADED. Measure M1.] ;
  62:  PAUSE ;
  63:  MESSAGE[Experiment 2/4: take the] ;
  64:  MESSAGE[load off. The robot] ;
  65:  MESSAGE[moves next.] ;
  66:  PAUSE ;
  67:  !to AP2 ;
  68:J P[3] 10% FINE    ;
  69:  !to P2 ;
  70:J P[4] 10% FINE    ;
  71:  WAIT   2.00(sec) ;
  72:  MESSAGE[Experiment 3/4: pose 2.] ;
  73:  MESSAGE[NO load. Measure M1.] ;
  74:  PAUSE ;
  75:  MESSAGE[Experiment 3/4: hang] ;
  76:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  77:  MESSAGE[-2500 N.] ;
  78:  PAUSE ;
  79:  WAIT   2.00(sec) ;
  80:  MESSAGE[Experiment 3/4: pose 2.] ;
  81:  MESSAGE[LOADED. Measure M1.] ;
  82:  PAUSE ;
  83:  MESSAGE[Experiment 3/4: take the] ;
  84:  MESSAGE[load off. The robot] ;
  85:  MESSAGE[moves next.] ;
  86:  PAUSE ;
  87:  !to AP3 ;
  88:J P[5] 10% FINE    ;
  89:  !to P3 ;
  90:J P[6] 10% FINE    ;
  91:  WAIT   2.00(sec) ;
  92:  MESSAGE[Experiment 4/4: pose 3.] ;
  93:  MESSAGE[NO load. Measure M1.] ;
  94:  PAUSE ;
  95:  MESSAGE[Experiment 4/4: hang] ;
  96:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  97:  MESSAGE[-2500 N.] ;
  98:  PAUSE ;
  99:  WAIT   2.00(sec) ;
 100:  MESSAGE[Experiment 4/4: pose 3.] ;
 101:  MESSAGE[LOADED. Measure M1.] ;
 102:  PAUSE ;
 103:  MESSAGE[Experiment 4/4: take the] ;
 104:  MESSAGE[load off. The robot] ;
 105:  MESSAGE[moves next.] ;
 106:  PAUSE ;
 107:  !to AP3 ;
 108:J P[5] 10% FINE    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=  -51.2922 deg,	J3=   62.5588 deg,
	J4=  -32.0611 deg,	J5=  101.1598 deg,	J6=  -94.2903 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=  -50.7922 deg,	J3=   63.0588 deg,
	J4=  -32.5611 deg,	J5=  101.6598 deg,	J6=  -93.7903 deg
};
P[3]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=  -55.9571 deg,	J3=  -72.9034 deg,
	J4= -118.8938 deg,	J5=  -57.0916 deg,	J6= -179.7668 deg
};
P[4]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=  -55.4571 deg,	J3=  -72.4034 deg,
	J4= -119.3938 deg,	J5=  -56.5916 deg,	J6= -179.2668 deg
};
P[5]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=   -2.1852 deg,	J3=   -4.2994 deg,
	J4=  -57.7496 deg,	J5=   39.0358 deg,	J6=  168.3163 deg
};
P[6]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=   -1.6852 deg,	J3=   -3.7994 deg,
	J4=  -58.2496 deg,	J5=   39.5358 deg,	J6=  168.8163 deg
};
/END
